//! What another program says of the same circles, next to what the method `circular` finds.

use crate::{Error, files};
use std::path::Path;
use trunnion_record::b5r::{BarResult, Feature};
use trunnion_results::number::unit_on_screen;
use trunnion_results::{Cell, Column, Findings, FoundValue, Table};

/// Adds the numbers of a `.b5r` file to findings of the method `circular`: a table with ours next to them, and what it leaves open.
///
/// # Errors
/// A file that cannot be read, or findings without circles in its plane.
pub fn add_bar_result(findings: &mut Findings, path: &Path) -> Result<(), Error> {
    let refused = |why: String| Error::NoSecondOpinion { path: path.into(), why };
    let theirs = BarResult::parse(&files::read(path)?).map_err(|why| refused(why.to_string()))?;
    let plane = theirs.plane.clone().unwrap_or_default().to_uppercase();
    let Some(axes) = PLANES.into_iter().find(|axes| axes.concat() == plane) else {
        return Err(refused(format!("its plane is \"{plane}\"; allowed: XY, YZ, ZX")));
    };
    let of_plane = format!("{plane} ");
    let has_plane = findings.values.iter().any(|value| value.name.starts_with(&of_plane));
    // Of doubted runs there may be no values: the doubt is the answer.
    if !has_plane && findings.plausibility.is_empty() {
        return Err(refused(format!("the runs have no circle in {plane}; its numbers are of that plane")));
    }
    let table = table(findings, &theirs, axes);
    findings.tables.push(table);
    findings.notes.push(format!(
        "Second opinion: {}. Its analysis gives every feature a number and no share that is left: what the list does not explain is ours alone.",
        about(&theirs, path)
    ));
    findings.notes.push(
        "Header and ranking of the file are read by names that a public reader uses; names of its readings are not public. That A is the first axis of the \
         plane, that its circularity is our G(b), and the signs of its numbers are not confirmed: compare sizes first."
            .into(),
    );
    Ok(())
}

/// First and second axis of each plane.
const PLANES: [[&str; 2]; 3] = [["X", "Y"], ["Y", "Z"], ["Z", "X"]];

/// Which file of what.
fn about(theirs: &BarResult, path: &Path) -> String {
    let said = [
        ("test", &theirs.test),
        ("machine", &theirs.machine),
        ("of", &theirs.begun),
        ("by", &theirs.operator),
        ("ball bar", &theirs.serial_number),
        ("calibrated", &theirs.calibrated),
    ];
    let said = said.into_iter().filter_map(|(what, text)| Some(format!(", {what} {}", text.as_ref()?)));
    std::iter::once(path.display().to_string()).chain(said).collect()
}

fn table(findings: &Findings, theirs: &BarResult, axes: [&str; 2]) -> Table {
    let heads = ["error", "theirs", "unit of theirs", "ours", "u", "unit of ours"];
    let ours =
        |name: &str| findings.values.iter().find(|value| value.name == format!("{} {name}", axes.concat()));
    let row = |name: String, theirs: Option<&Feature>, ours: Option<&FoundValue>| {
        let number = |number: Option<f64>| number.map_or(Cell::Missing, Cell::Number);
        let shown = |unit: Option<&str>| unit.map_or(Cell::Missing, |unit| Cell::Text(unit_on_screen(unit)));
        vec![
            Cell::Text(name),
            number(theirs.map(|feature| feature.value)),
            shown(theirs.map(|feature| feature.unit)),
            number(ours.and_then(|ours| ours.value)),
            number(ours.and_then(|ours| ours.u)),
            shown(ours.map(|ours| ours.unit.as_str())),
        ]
    };
    let of_feature = |feature: &Feature| {
        let found = our_name(&feature.name, axes).and_then(|name| ours(&name));
        row(feature.name.clone(), Some(feature), found)
    };
    let left = ["unexplained share", "unexplained beyond noise"];
    Table {
        caption: format!("What another program says of {}, next to ours", axes.concat()),
        columns: heads.map(|name| Column { name: name.into(), unit: None }).into(),
        rows: theirs
            .features
            .iter()
            .map(of_feature)
            .chain(left.map(|name| row(name.into(), None, ours(name))))
            .collect(),
    }
}

/// The error of our list that a feature is about; features of one error at the two ends of an axis, or of two ways, have the same.
fn our_name(feature: &str, [a, b]: [&str; 2]) -> Option<String> {
    let of_axis = [
        ("AF_STRAIGHTNESS_", "straightness"),
        ("AF_CYCLIC_ERROR_", "cyclic"),
        ("AF_BACKLASH_", "backlash"),
        ("AF_LATERAL_PLAY_", "lateral play"),
        ("AF_REVERSAL_SPIKES_", "reversal spike"),
    ];
    let axis = |rest: &str| match rest.split('_').next() {
        Some("A") => Some(a),
        Some("B") => Some(b),
        _ => None,
    };
    match feature {
        "AF_CIRCULARITY" => Some("G(b)".into()),
        "AF_SCALE_MISMATCH" => Some(format!("scale {a}−{b}")),
        "AF_SERVO_MISMATCH" => Some(format!("servo {a}−{b}")),
        // The later axis leans about the third (docs/design/physics.md §5.2).
        "AF_SQUARENESS" => Some(match a {
            "X" => "EC0Y".into(),
            "Y" => "EA0Z".into(),
            _ => "EB0Z".into(),
        }),
        _ => of_axis
            .iter()
            .find_map(|(begin, name)| Some(format!("{name} {}", axis(feature.strip_prefix(begin)?)?))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Made by hand from the public names.
    const FILE: &str = r#"<T><PLANE TEST_PLANE="XY"/><MACHINE_TESTED NAME="Mill 4"/>
        <FEATURE NAME="AF_SQUARENESS" DT="UT_SQUARENESS">29.4</FEATURE>
        <FEATURE NAME="AF_BACKLASH_B_NEG" DT="UT_LENGTH_UM">2.1</FEATURE>
        <FEATURE NAME="AF_NEW" DT="UT_PERCENT">3</FEATURE></T>"#;

    fn findings() -> Findings {
        let value = |name: &str, value, unit: &str| FoundValue {
            name: name.into(),
            value: Some(value),
            unit: unit.into(),
            u: Some(0.2),
            note: String::new(),
            ..FoundValue::default()
        };
        let values = vec![
            value("XY EC0Y", 30.1, "urad"),
            value("XY backlash Y", -2.0, "µm"),
            value("XY unexplained share", 0.07, ""),
        ];
        Findings { values, ..Findings::default() }
    }

    #[test]
    fn their_numbers_stand_next_to_ours_with_the_share_that_they_leave_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("xy.b5r");
        std::fs::write(&path, FILE).unwrap();
        let mut findings = findings();
        add_bar_result(&mut findings, &path).unwrap();
        let rows = &findings.tables[0].rows;
        let numbers = |row: usize| [rows[row][1].clone(), rows[row][3].clone()];
        assert_eq!(numbers(0), [Cell::Number(29.4), Cell::Number(30.1)]);
        assert_eq!(rows[0][5], Cell::Text("µrad".into()), "no id of a unit on a screen");
        assert_eq!(numbers(1), [Cell::Number(2.1), Cell::Number(-2.0)]);
        assert_eq!(numbers(2), [Cell::Number(3.0), Cell::Missing]);
        assert_eq!(numbers(3), [Cell::Missing, Cell::Number(0.07)]);
        assert!(findings.notes[0].contains("Mill 4"), "{:?}", findings.notes);
    }

    #[test]
    fn a_file_of_another_plane_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("yz.b5r");
        std::fs::write(&path, FILE.replace("XY", "YZ")).unwrap();
        let why = add_bar_result(&mut findings(), &path).unwrap_err().to_string();
        assert!(why.contains("yz.b5r") && why.contains("YZ"), "{why}");
    }
}
