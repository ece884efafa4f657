//! The kinds of instruments: what a file calls them and what they read.

/// What measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InstrumentKind {
    /// Three displacement probes around a ball: x, y, z of the ball relative to the nest.
    RTest,
    /// Ball bar: change of the distance between two balls.
    BallBar,
    /// Tracking interferometer: change of the distance from a station on the table to a reflector in the spindle.
    Tracker,
    /// Laser tracker: x, y, z of a reflector in the spindle or on a flange, in the axes of the tracker.
    LaserTracker,
    /// Laser ball bar, or one leg of a passive parallel link: length between two balls, far apart or near.
    LaserBallBar,
    /// Passive serial link of two arms: its two joint angles.
    PassiveArm,
    /// Cross-grid encoder (grid plate): both coordinates of a head in the plane of the grid.
    CrossGrid,
    /// Level, autocollimator or angular interferometer: turn about one direction.
    Level,
    /// Laser interferometer along a line, for example a body diagonal.
    Diagonal,
    /// Laser interferometer with a flat mirror while X, Y and Z step in turn.
    StepDiagonal,
    /// Calibrated balls on a plate, each centre touched or read in x, y, z.
    BallPlate,
    /// Touch-trigger probe: centre of a sphere, x, y, z.
    TouchProbe,
    /// Touch-trigger probe: a face, along its normal.
    TouchProbeFace,
    /// A machined surface, measured afterwards along its normal.
    MachinedSurface,
}

/// One number of a reading in a points file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ReadingColumn {
    /// Deviation, µm: `dx_um` …
    Deviation(&'static str),
    /// Length or coordinate, mm: `l_mm`, `reflector_x_mm` …
    Length(&'static str),
    /// Joint angle of an arm of known length, degrees: `j1_deg`; inside the arc at the end of that arm, mm.
    Angle(&'static str),
}

impl ReadingColumn {
    /// Name of the column.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deviation(name) | Self::Length(name) | Self::Angle(name) => name,
        }
    }
}

const XYZ: &[ReadingColumn] = &[
    ReadingColumn::Deviation("dx_um"),
    ReadingColumn::Deviation("dy_um"),
    ReadingColumn::Deviation("dz_um"),
];
const LENGTH: &[ReadingColumn] = &[ReadingColumn::Length("l_mm")];
const REFLECTOR: &[ReadingColumn] = &[
    ReadingColumn::Length("reflector_x_mm"),
    ReadingColumn::Length("reflector_y_mm"),
    ReadingColumn::Length("reflector_z_mm"),
];
const GRID: &[ReadingColumn] = &[ReadingColumn::Length("u_mm"), ReadingColumn::Length("v_mm")];
const TURN: &[ReadingColumn] = &[ReadingColumn::Deviation("angle_um_per_m")];
const ANGLES: &[ReadingColumn] = &[ReadingColumn::Angle("j1_deg"), ReadingColumn::Angle("j2_deg")];
const NORMAL: &[ReadingColumn] = &[ReadingColumn::Deviation("dn_um")];

/// What files and checks know of a kind.
struct Row {
    kind: InstrumentKind,
    /// Name in files.
    name: &'static str,
    /// What it is called in sentences, with its article.
    words: &'static str,
    /// Names of the components of one reading.
    components: &'static [&'static str],
    /// What one component is called in sentences.
    reads: &'static str,
    /// Columns of a points file that hold them.
    columns: &'static [ReadingColumn],
    /// What a setup of it must hold, next to name and place.
    keys: &'static [Key],
}

/// What a setup file may have to hold.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Key {
    /// `bar_length_mm`.
    BarLength,
    /// `direction`.
    Direction,
    /// `arms_mm`.
    Arms,
    /// `artefact`; every point names one of its targets.
    Targets,
    /// `normal` of each target.
    Normals,
}

/// Every kind, one row each.
const ROWS: &[Row] = &[
    row(InstrumentKind::RTest, "r-test", "an R-test", &["x", "y", "z"], "reading", XYZ, &[]),
    row(
        InstrumentKind::BallBar,
        "ball-bar",
        "a ball bar",
        &["r"],
        "bar length",
        &[ReadingColumn::Deviation("dr_um")],
        &[Key::BarLength],
    ),
    row(
        InstrumentKind::Tracker,
        "tracker",
        "a tracking interferometer",
        &["l"],
        "distance from the station",
        LENGTH,
        &[],
    ),
    row(
        InstrumentKind::LaserTracker,
        "laser-tracker",
        "a laser tracker",
        &["x", "y", "z"],
        "reading",
        REFLECTOR,
        &[],
    ),
    row(
        InstrumentKind::LaserBallBar,
        "laser-ball-bar",
        "a laser ball bar",
        &["l"],
        "bar length",
        LENGTH,
        &[],
    ),
    row(
        InstrumentKind::PassiveArm,
        "passive-arm",
        "a passive arm",
        &["j1", "j2"],
        "joint angle of the arm",
        ANGLES,
        &[Key::Arms],
    ),
    row(
        InstrumentKind::CrossGrid,
        "cross-grid",
        "a cross-grid encoder",
        &["u", "v"],
        "coordinate on the grid",
        GRID,
        &[Key::Direction],
    ),
    row(
        InstrumentKind::Level,
        "level",
        "a level",
        &["angle"],
        "reading of the level",
        TURN,
        &[Key::Direction],
    ),
    row(
        InstrumentKind::Diagonal,
        "diagonal",
        "an interferometer",
        &["l"],
        "reading along the beam",
        LENGTH,
        &[Key::Direction],
    ),
    row(
        InstrumentKind::StepDiagonal,
        "step-diagonal",
        "an interferometer with a flat mirror",
        &["l"],
        "reading along the beam",
        LENGTH,
        &[Key::Direction],
    ),
    row(
        InstrumentKind::BallPlate,
        "ball-plate",
        "a ball plate",
        &["x", "y", "z"],
        "reading",
        XYZ,
        &[Key::Targets],
    ),
    row(InstrumentKind::TouchProbe, "touch-probe", "a touch probe", &["x", "y", "z"], "reading", XYZ, &[]),
    row(
        InstrumentKind::TouchProbeFace,
        "touch-probe-face",
        "a touch probe on faces",
        &["n"],
        "reading along the normal",
        NORMAL,
        &[Key::Targets, Key::Normals],
    ),
    row(
        InstrumentKind::MachinedSurface,
        "machined-surface",
        "a probe on a machined surface",
        &["n"],
        "reading along the normal",
        NORMAL,
        &[Key::Targets, Key::Normals],
    ),
];

const fn row(
    kind: InstrumentKind,
    name: &'static str,
    words: &'static str,
    components: &'static [&'static str],
    reads: &'static str,
    columns: &'static [ReadingColumn],
    keys: &'static [Key],
) -> Row {
    Row { kind, name, words, components, reads, columns, keys }
}

impl InstrumentKind {
    /// Every kind with its name in files.
    pub const NAMES: [(&'static str, Self); ROWS.len()] = {
        let mut names = [("", Self::RTest); ROWS.len()];
        let mut i = 0;
        while i < ROWS.len() {
            names[i] = (ROWS[i].name, ROWS[i].kind);
            i += 1;
        }
        names
    };

    fn row(self) -> &'static Row {
        ROWS.iter().find(|row| row.kind == self).expect("every kind has a row of ROWS")
    }

    fn needs(self, key: Key) -> bool {
        self.row().keys.contains(&key)
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// What it is called in sentences, with its article: `an R-test`.
    pub fn with_article(self) -> &'static str {
        self.row().words
    }

    /// The same without its article: `R-test`.
    pub fn title(self) -> &'static str {
        self.with_article().split_once(' ').map_or(self.with_article(), |(_, title)| title)
    }

    /// Names of the components of one reading.
    pub fn components(self) -> &'static [&'static str] {
        self.row().components
    }

    /// What one component is called in sentences where it is none of three directions: `bar length`, `reading along the beam`, …
    pub fn reads(self) -> &'static str {
        self.row().reads
    }

    /// Columns of a points file that hold the components, in their order.
    pub fn columns(self) -> &'static [ReadingColumn] {
        self.row().columns
    }

    /// True when contact probes are deflected by what they read, so that their gain counts.
    pub fn deflects_probes(self) -> bool {
        matches!(self, Self::RTest | Self::BallBar)
    }

    /// True when it keeps a length from the table's ball to the tool's instead of bringing both together.
    pub fn keeps_bar_length(self) -> bool {
        self.needs(Key::BarLength)
    }

    /// True when it reads a turn: µm are then those at the end of one metre.
    pub fn reads_turn(self) -> bool {
        self == Self::Level
    }

    /// True when it reads along, about or across a direction of its setup.
    pub fn has_direction(self) -> bool {
        self.needs(Key::Direction)
    }

    /// True when it is made of two arms.
    pub fn has_arms(self) -> bool {
        self.needs(Key::Arms)
    }

    /// True when every point names one of the targets of its setup.
    pub fn has_targets(self) -> bool {
        self.needs(Key::Targets)
    }

    /// True when targets are faces with a normal.
    pub fn has_normals(self) -> bool {
        self.needs(Key::Normals)
    }
}
