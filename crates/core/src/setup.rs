//! A setup: one instrument mounted in one way. The `[[setup]]` tables of docs/design/contracts.md §2.

use crate::artefact::{Artefact, read_artefact};
use crate::calibration::{Calibration, read_calibrations};
use crate::input::{Document, Table};
use crate::kind::{InstrumentKind, ReadingColumn};
use crate::renamed::{Renamed, read_columns};
use crate::{Problems, convert};
use nalgebra::{Point3, Unit, Vector3};

/// How far balls that are set by hand may be off their places, mm.
pub const SET_BY_HAND_MM: f64 = 1.0;

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
    /// Nominal centre of the table-side ball or nest in table coordinates, mm; the station of a tracker, the origin of an
    /// artefact, the foot of a link, the start of a laser line.
    pub ball_in_table_mm: Point3<f64>,
    /// Nominal length of the ball bar, mm; of a tracker its dead path.
    pub bar_length_mm: Option<f64>,
    /// Nominal centre of the spindle-side ball, nest, reflector or stylus in tool coordinates, mm.
    pub ball_in_tool_mm: Point3<f64>,
    /// Direction of a laser line, machine axes; normal of a grid plate, table axes; of a ball bar, from the table's ball to the
    /// tool's, where it differs from the cycle's.
    pub direction: Option<Unit<Vector3<f64>>>,
    /// Lengths of the two arms of a passive link, from the table outward, mm.
    pub arms_mm: Option<[f64; 2]>,
    /// True when the length of a bar (the zero of a laser ball bar, the axes of a laser tracker, the radius of a stylus or tool,
    /// the form of an artefact) is calibrated: known, not an unknown.
    pub calibrated: bool,
    /// What is measured at several places.
    pub artefact: Option<Artefact>,
}

impl Setup {
    /// A setup with nothing but its place.
    pub fn new(
        name: impl Into<String>,
        instrument: InstrumentKind,
        nest: NestSide,
        ball_in_table_mm: Point3<f64>,
    ) -> Self {
        Self {
            name: name.into(),
            instrument,
            nest,
            ball_in_table_mm,
            bar_length_mm: None,
            ball_in_tool_mm: Point3::origin(),
            direction: None,
            arms_mm: None,
            calibrated: false,
            artefact: None,
        }
    }

    /// True for a bar whose readings count from its length; those of others only say how it changes.
    pub fn reads_calibrated_length(&self) -> bool {
        self.calibrated && self.instrument.keeps_bar_length()
    }

    /// Nominal place of what is measured at a target, table axes, mm; without an artefact the place of the setup.
    pub fn target_in_table_mm(&self, target: usize) -> Point3<f64> {
        let of_artefact = |artefact: &Artefact| artefact.target_in_table_mm(&self.ball_in_table_mm, target);
        self.artefact.as_ref().map_or(self.ball_in_table_mm, of_artefact)
    }

    /// Number of targets, at least one.
    pub fn targets(&self) -> usize {
        self.artefact.as_ref().map_or(1, |artefact| artefact.targets.len())
    }

    /// Directions of the two gratings of a plate, table axes: along the letter that follows that of its normal (X, Y, Z, X), and square
    /// to it, right-handed about the normal.
    pub fn gratings(&self) -> [Unit<Vector3<f64>>; 2] {
        let normal = self.direction.unwrap_or_else(Vector3::z_axis);
        let next = Vector3::ith((normal.iamax() + 1) % 3, 1.0);
        let first = convert::unit(next - normal.into_inner() * normal.dot(&next));
        [first, convert::unit(normal.cross(&first))]
    }

    /// Component `i` of a reading, mm, from the number in its column of a points file.
    pub fn reading_from_column_mm(&self, i: usize, number: f64) -> f64 {
        match self.instrument.columns()[i] {
            ReadingColumn::Deviation(_) => convert::mm_from_um(number),
            ReadingColumn::Length(_) => number,
            ReadingColumn::Angle(_) => convert::rad_from_deg(number) * self.arm_mm(i),
        }
    }

    /// The number in the column of component `i` from a reading, mm.
    pub fn column_from_reading(&self, i: usize, reading_mm: f64) -> f64 {
        match self.instrument.columns()[i] {
            ReadingColumn::Deviation(_) => convert::um_from_mm(reading_mm),
            ReadingColumn::Length(_) => reading_mm,
            ReadingColumn::Angle(_) => convert::deg_from_rad(reading_mm / self.arm_mm(i)),
        }
    }

    fn arm_mm(&self, i: usize) -> f64 {
        self.arms_mm.map_or(1.0, |arms| arms[i])
    }
}

/// The parsed `setup.toml` of a points file.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupFile {
    /// Machine name or path.
    pub machine: String,
    /// The setups, in file order.
    pub setups: Vec<Setup>,
    /// Which columns of a table of another program hold what; empty for a points file.
    pub columns: Vec<Renamed>,
    /// What the certificates of the sensors say.
    pub calibrations: Vec<Calibration>,
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
    let columns = read_columns(&root);
    let calibrations = read_calibrations(&root, None);
    root.no_other_keys();
    drop(root);
    let parsed = || {
        format?;
        Some(SetupFile { machine: machine?, setups: setups?, columns: columns?, calibrations: calibrations? })
    };
    document.finish(parsed())
}

/// The machine that a setup file names, whatever else is wrong with the file.
pub fn machine_of_setup_file(file: &str, text: &str) -> Option<String> {
    let document = Document::parse(file, text).ok()?;
    let root = document.root();
    root.string("machine")
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
    let bar_length_mm = table.optional_number("bar_length_mm", 0.0..=20_000.0);
    if instrument.is_some_and(InstrumentKind::keeps_bar_length)
        && bar_length_mm.is_none_or(|length| length < 10.0)
    {
        table.problem("bar_length_mm", "is missing", "10..=3000", "A ball bar needs its nominal length.");
    }
    let ball_in_tool = table.optional_vector3("ball_in_tool_mm").unwrap_or_else(Vector3::zeros);
    let direction = table.optional_vector3("direction");
    if instrument.is_some_and(InstrumentKind::has_direction)
        && direction.is_none_or(|along| along.norm() < 1e-6)
    {
        let allowed = "the direction of the beam, of the turn or of the normal, e.g. [0, 0, 1]";
        table.problem("direction", "is missing or has no length", allowed, "");
    }
    let arms_mm = table.optional_numbers("arms_mm").and_then(|arms| <[f64; 2]>::try_from(arms).ok());
    if instrument.is_some_and(InstrumentKind::has_arms) && arms_mm.is_none_or(|[a, b]| a < 1.0 || b < 1.0) {
        table.problem("arms_mm", "is missing", "the lengths of both arms, e.g. [250, 250]", "");
    }
    let calibrated = table.boolean_or("calibrated", false);
    let artefact = match table.optional_table("artefact") {
        Some(table) => Some(read_artefact(&table, instrument)?),
        None => None,
    };
    if artefact.is_none() && instrument.is_some_and(InstrumentKind::has_targets) {
        let allowed = "[setup.artefact] with a [[setup.artefact.target]] for each place";
        table.problem("artefact", "is missing", allowed, "");
    }
    table.no_other_keys();
    Some(Setup {
        bar_length_mm,
        ball_in_tool_mm: Point3::from(ball_in_tool),
        direction: direction.filter(|along| along.norm() > 0.0).map(convert::unit),
        arms_mm,
        calibrated: calibrated?,
        artefact,
        ..Setup::new(name?, instrument?, nest, Point3::from(ball?))
    })
}
