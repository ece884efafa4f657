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
    /// Laser ball bar, or one leg of a passive parallel link: length between two balls, far apart or near.
    LaserBallBar,
    /// Passive serial link of two arms: its two joint angles.
    PassiveArm,
    /// Laser interferometer along a body diagonal.
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
    /// Length, mm: `l_mm`.
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
const NORMAL: &[ReadingColumn] = &[ReadingColumn::Deviation("dn_um")];

impl InstrumentKind {
    /// Every kind with its name in files.
    pub const NAMES: [(&'static str, Self); 11] = [
        ("r-test", Self::RTest),
        ("ball-bar", Self::BallBar),
        ("tracker", Self::Tracker),
        ("laser-ball-bar", Self::LaserBallBar),
        ("passive-arm", Self::PassiveArm),
        ("diagonal", Self::Diagonal),
        ("step-diagonal", Self::StepDiagonal),
        ("ball-plate", Self::BallPlate),
        ("touch-probe", Self::TouchProbe),
        ("touch-probe-face", Self::TouchProbeFace),
        ("machined-surface", Self::MachinedSurface),
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, kind)| *kind == self).expect("every kind is listed").0
    }

    /// Names of the components of one reading.
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::RTest | Self::BallPlate | Self::TouchProbe => &["x", "y", "z"],
            Self::BallBar => &["r"],
            Self::Tracker | Self::LaserBallBar | Self::Diagonal | Self::StepDiagonal => &["l"],
            Self::PassiveArm => &["j1", "j2"],
            Self::TouchProbeFace | Self::MachinedSurface => &["n"],
        }
    }

    /// Columns of a points file that hold the components, in their order.
    pub fn columns(self) -> &'static [ReadingColumn] {
        match self {
            Self::RTest | Self::BallPlate | Self::TouchProbe => XYZ,
            Self::BallBar => &[ReadingColumn::Deviation("dr_um")],
            Self::Tracker | Self::LaserBallBar | Self::Diagonal | Self::StepDiagonal => LENGTH,
            Self::PassiveArm => &[ReadingColumn::Angle("j1_deg"), ReadingColumn::Angle("j2_deg")],
            Self::TouchProbeFace | Self::MachinedSurface => NORMAL,
        }
    }

    /// True when contact probes are deflected by what they read, so that their gain counts.
    pub fn deflects_probes(self) -> bool {
        matches!(self, Self::RTest | Self::BallBar)
    }

    /// True when it keeps a length from the table's ball to the tool's instead of bringing both together.
    pub fn keeps_bar_length(self) -> bool {
        self == Self::BallBar
    }

    /// True when every point names one of the targets of its setup.
    pub fn has_targets(self) -> bool {
        matches!(self, Self::BallPlate | Self::TouchProbeFace | Self::MachinedSurface)
    }

    /// True when targets are faces with a normal.
    pub fn has_normals(self) -> bool {
        matches!(self, Self::TouchProbeFace | Self::MachinedSurface)
    }
}
