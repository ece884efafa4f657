//! The machine file, `format = "trunnion-machine/1"` (docs/design/contracts.md §3).

mod legs;
mod moves;

use crate::{Axis, Machine, NamePlate};
use moves::{FARTHEST_MM, moves};
use nalgebra::{Point3, Vector3};
use std::ffi::OsStr;
use std::path::Path;
use trunnion_core::input::{Document, Table};
use trunnion_core::names::nearest;
use trunnion_core::{Joint, Problems, convert};

/// What stands before the name of a joint in an expression for its velocity, acceleration, direction and travel since it
/// turned round.
pub const QUANTITY_PREFIXES: [&str; 4] = ["v", "a", "dir", "since"];

impl Machine {
    /// What a machine is called of which another file says this: a name, or the path of a machine file, which is called after it.
    pub fn name_of(named: &str) -> &str {
        let path = Path::new(named);
        let is_file = path.extension().is_some_and(|ending| ending == "toml");
        path.file_stem().filter(|_| is_file).and_then(OsStr::to_str).unwrap_or(named)
    }

    /// Reads a machine file. `name` is what runs and models call the machine; `file` is shown in problems.
    ///
    /// # Errors
    /// Every problem of the file, with line, what was found and what is allowed.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(file, text)?;
        let machine = read(name, &document);
        document.finish(machine)
    }
}

fn read(name: &str, document: &Document<'_>) -> Option<Machine> {
    let root = document.root();
    let format = root.format("trunnion-machine/1");
    root.optional_string("about");
    NamePlate::read(&root);
    let names = [root.strings("table"), root.strings("tool")];
    let tables = root.table("axis")?;
    let chains = joints(&root, &tables, &names)?;
    let letters: Vec<Joint> = chains.iter().flatten().flatten().copied().collect();
    let parallel = root.has("tripod").then(|| legs::legs(&root, &tables, chains[1].as_deref()));
    let of_legs: Vec<Joint> = match (&parallel, &chains[1]) {
        (Some(_), Some(tool)) => tool.iter().copied().take(3).collect(),
        _ => Vec::new(),
    };
    let in_series = letters.iter().filter(|letter| !of_legs.contains(letter));
    let mut axes: Vec<Option<Axis>> = in_series.map(|&letter| axis(&tables, letter)).collect();
    if let Some(Some((_, legs))) = &parallel {
        axes.extend(legs.iter().cloned().map(Some));
    }
    tables.no_other_keys();
    let spindle = spindle(&root, chains[1].as_deref());
    root.no_other_keys();
    format?;
    let [table, tool] = chains;
    let find = |letter: Joint| axes.iter().flatten().find(|axis| axis.letter == letter).cloned();
    Some(Machine {
        name: name.into(),
        table: table?.into_iter().map(find).collect::<Option<_>>()?,
        tool: tool?.into_iter().map(find).collect::<Option<_>>()?,
        tripod: match parallel {
            Some(read) => Some(read?.0),
            None => None,
        },
        spindle,
    })
}

/// The joint that the file calls its spindle.
fn spindle(root: &Table<'_>, tool: Option<&[Joint]>) -> Option<Joint> {
    let name = root.optional_string("spindle")?;
    let last = tool?.last().copied();
    let found = last.filter(|joint| joint.is_rotary() && joint.as_str() == name);
    if found.is_none() {
        let allowed =
            last.map_or("the last joint of tool".into(), |last| format!("\"{last}\", a rotary joint"));
        let advice = "The spindle is the last joint of tool.";
        root.problem("spindle", format!("= \"{name}\""), allowed, advice);
    }
    found
}

/// The joints of both chains; a letter of ISO 841 has its kind, of any other name the table of the axis says it.
fn joints(
    root: &Table<'_>,
    tables: &Table<'_>,
    sides: &[Option<Vec<String>>; 2],
) -> Option<[Option<Vec<Joint>>; 2]> {
    let names: Vec<&str> = sides.iter().flatten().flatten().map(String::as_str).collect();
    for (i, name) in names.iter().enumerate() {
        if names[..i].iter().any(|other| other.eq_ignore_ascii_case(name)) {
            root.problem("tool", format!("names {name} twice"), "each axis once, in table or in tool", "");
            return None;
        }
    }
    let with_kind: Option<Vec<_>> = names
        .iter()
        .map(|&name| match Joint::parse(name) {
            Some(letter) => Some((name, letter.is_rotary())),
            None => {
                let kind = table_of(tables, name)?.optional_string("kind");
                Some((name, kind.as_deref() == Some("rotary")))
            }
        })
        .collect();
    let joints = match Joint::chain(&with_kind?) {
        Ok(joints) => joints,
        Err(error) => {
            let key = if sides[1].as_ref().is_some_and(|tool| !tool.is_empty()) { "tool" } else { "table" };
            let allowed = "letters X Y Z U V W A B C, or names such as j1, S, track";
            root.problem(key, format!("= {names:?}: {error}"), allowed, "");
            return None;
        }
    };
    if let Some((a, b)) = quantity_of_another(&joints) {
        let allowed = "names that expressions can distinguish";
        root.problem("tool", format!("has joints {a} and {b}: {b} is also a quantity of {a}"), allowed, "");
    }
    let on_table = sides[0].as_ref().map_or(0, Vec::len);
    let side = |of: &Option<Vec<String>>, joints: &[Joint]| of.as_ref().map(|_| joints.to_vec());
    Some([side(&sides[0], &joints[..on_table]), side(&sides[1], &joints[on_table..])])
}

/// Two joints of which one name is a prefix of expressions (v, a, dir, since) and the other.
fn quantity_of_another(joints: &[Joint]) -> Option<(Joint, Joint)> {
    let letters = Joint::ISO;
    let pairs = letters.iter().chain(joints).flat_map(|&a| joints.iter().map(move |&b| (a, b)));
    pairs
        .into_iter()
        .find(|(a, b)| QUANTITY_PREFIXES.iter().any(|prefix| format!("{prefix}{}", a.as_str()) == b.as_str()))
}

/// The table of a joint, or a problem with the nearest name of those there are.
fn table_of<'d>(tables: &Table<'d>, joint: &str) -> Option<Table<'d>> {
    let keys = tables.keys();
    if keys.iter().any(|key| key == joint) {
        return tables.optional_table(joint);
    }
    let near = nearest(joint, keys.iter().map(String::as_str));
    let advice = near.map_or(String::new(), |near| format!("Did you mean {near}?"));
    tables.problem(joint, "is missing", "a table for each axis of table and tool", &advice);
    None
}

fn axis(tables: &Table<'_>, letter: Joint) -> Option<Axis> {
    let table = table_of(tables, letter.as_str())?;
    let kind = table.one_of("kind", &["linear", "rotary"]);
    let rotary = letter.is_rotary();
    if kind.as_deref().is_some_and(|kind| (kind == "rotary") != rotary) {
        table.problem(
            "kind",
            "does not fit the letter",
            "linear for X, Y, Z, U, V, W; rotary for A, B, C",
            "",
        );
    }
    let direction = table.vector3("direction");
    if direction.is_some_and(|d| d.norm() < 1e-6) {
        table.problem("direction", "has no length", "a vector such as [0, 0, 1]", "");
        return None;
    }
    let through_mm = if rotary { table.vector3("through_mm") } else { Some(Vector3::zeros()) };
    let moves = moves(&table, rotary);
    table.no_other_keys();
    let (through_mm, moves) = (through_mm?, moves?);
    if through_mm.amax() > FARTHEST_MM {
        table.problem("through_mm", "is out of reach", format!("within ±{FARTHEST_MM} mm"), "");
    }
    Some(Axis {
        letter,
        direction: convert::unit(direction?),
        through_mm: Point3::from(through_mm),
        sense: moves.sense,
        travel: moves.travel,
        facts: moves.facts,
    })
}
