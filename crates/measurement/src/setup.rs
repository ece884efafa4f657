//! A setup: one instrument mounted in one way. The `[[setup]]` tables of DESIGN §3.2.

use nalgebra::Point3;
use trunnion_units::Problems;
use trunnion_units::input::{Document, Table};

/// What measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InstrumentKind {
    /// Three displacement probes around a ball: x, y, z of the ball relative to the nest.
    RTest,
    /// Ball bar: change of the distance between two balls.
    BallBar,
}

impl InstrumentKind {
    /// Every kind with its name in files.
    pub const NAMES: [(&'static str, Self); 2] = [("r-test", Self::RTest), ("ball-bar", Self::BallBar)];

    /// Name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, kind)| *kind == self).expect("every kind is listed").0
    }

    /// Names of the components of one reading.
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::RTest => &["x", "y", "z"],
            Self::BallBar => &["r"],
        }
    }
}

/// Which side the R-test nest (or the fixed end of the bar) rides on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NestSide {
    /// Nest on the table, ball in the spindle (S1): readings in table axes.
    Table,
    /// Nest in the spindle, ball on the table (S0): readings in machine axes.
    Spindle,
}

/// One instrument mounted in one way.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Name, unique in the run.
    pub name: String,
    /// What measures.
    pub instrument: InstrumentKind,
    /// Where the nest rides.
    pub nest: NestSide,
    /// Nominal centre of the table-side ball or nest in table coordinates, mm.
    pub ball_in_table_mm: Point3<f64>,
    /// Nominal length of the ball bar, mm.
    pub bar_length_mm: Option<f64>,
}

/// The parsed `setup.toml` of a points file.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupFile {
    /// Machine name or path.
    pub machine: String,
    /// The setups, in file order.
    pub setups: Vec<Setup>,
}

/// Reads `setup.toml`, `format = "trunnion-points/1"`.
///
/// # Errors
/// Every problem of the file with its line.
pub fn parse_setup_file(file: &str, text: &str) -> Result<SetupFile, Problems> {
    let document = Document::parse(file, text)?;
    let root = document.root();
    let format = root.format("trunnion-points/1");
    let machine = root.string("machine");
    let setups = read_setups(&root);
    root.no_other_keys();
    drop(root);
    let parsed = format.zip(machine).zip(setups).map(|((_, machine), setups)| SetupFile { machine, setups });
    document.finish(parsed)
}

/// Reads the `[[setup]]` tables of a file; notes duplicate names and an empty list.
pub fn read_setups(root: &Table<'_>) -> Option<Vec<Setup>> {
    let tables = root.tables("setup");
    if tables.is_empty() {
        root.problem("setup", "has no entry", "at least one [[setup]]", "Add a [[setup]] table.");
    }
    let mut setups: Vec<Setup> = Vec::new();
    for table in &tables {
        let Some(setup) = read_setup(table) else { continue };
        if setups.iter().any(|other| other.name == setup.name) {
            table.problem(
                "name",
                format!("= \"{}\" appears twice", setup.name),
                "a name of its own for each setup",
                "",
            );
        }
        setups.push(setup);
    }
    (!setups.is_empty() && setups.len() == tables.len()).then_some(setups)
}

fn read_setup(table: &Table<'_>) -> Option<Setup> {
    let name = table.string("name");
    let instruments = InstrumentKind::NAMES.map(|(name, _)| name);
    let instrument = table.one_of("instrument", &instruments).and_then(|text| {
        InstrumentKind::NAMES.into_iter().find(|(name, _)| *name == text).map(|(_, kind)| kind)
    });
    let nest = match table.optional_one_of("nest", &["table", "spindle"]).as_deref() {
        Some("spindle") => NestSide::Spindle,
        _ => NestSide::Table,
    };
    let ball = table.vector3("ball_in_table_mm");
    let bar_length_mm = table.optional_number("bar_length_mm", 10.0..=3000.0);
    if instrument == Some(InstrumentKind::BallBar) && !table.has("bar_length_mm") {
        table.problem("bar_length_mm", "is missing", "10..=3000", "A ball bar needs its nominal length.");
    }
    table.no_other_keys();
    Some(Setup {
        name: name?,
        instrument: instrument?,
        nest,
        ball_in_table_mm: Point3::from(ball?),
        bar_length_mm,
    })
}
