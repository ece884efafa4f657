//! A row of units under the header, as data loggers and people write it. Our names hold their units: both must agree.

use super::notes::Notes;
use crate::rows::Cell;

/// Units of columns as names end with them, and how else they are written.
const UNITS: [(&str, &[&str]); 6] = [
    ("mm", &["mm"]),
    ("um", &["um", "µm", "μm", "micron", "microns"]),
    ("deg", &["deg", "°", "degree", "degrees", "grad"]),
    ("s", &["s", "sec"]),
    ("degc", &["degc", "°c", "deg c", "c"]),
    // Of no column: a row of them is one of units all the same.
    ("", &["-", "m", "inch", "in", "rad", "nm", "min", "ms", "h", "°f", "k"]),
];

/// The unit of a cell as names end with it; `None` of another text.
fn unit(cell: &str) -> Option<&'static str> {
    let bare = cell.trim_matches(['[', ']', '(', ')', ' ']).to_lowercase();
    UNITS.iter().find(|(_, written)| written.contains(&bare.as_str())).map(|(unit, _)| *unit)
}

/// Whether a row holds nothing but units.
pub(super) fn are(cells: &[Cell]) -> bool {
    cells.iter().all(|(_, cell)| cell.is_empty() || unit(cell).is_some())
}

/// Notes the units that are not those of the names.
pub(super) fn check(notes: &mut Notes<'_>, line: usize, names: &[String], cells: &[Cell]) {
    for (name, (at, cell)) in names.iter().zip(cells) {
        let own = name.rsplit_once('_').and_then(|(_, end)| unit(end)).filter(|own| !own.is_empty());
        if let (Some(own), Some(other)) = (own, unit(cell))
            && own != other
            && cell != "-"
        {
            let found = format!("the unit \"{cell}\" under {name}");
            notes.add(line, *at, &found, own, "Give the values in the unit of the name.");
        }
    }
}
