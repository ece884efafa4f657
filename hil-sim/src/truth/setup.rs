//! Setups of the virtual machine: as asked for, and as placed.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use trunnion_core::InstrumentKind;

/// One way of placing ball and nest.
#[derive(Clone, Debug, PartialEq)]
pub struct SimSetup {
    /// Name as in the cycle and points files.
    pub name: String,
    /// Where the nest is (R-test), ignored by the ball bar.
    pub nest: NestOn,
    /// Nominal centre of whatever the table carries (nest or ball), table axes, mm.
    pub ball_in_table_mm: Point3<f64>,
    /// What reads it.
    pub instrument: Instrument,
    /// Nominal centre of what the spindle carries, tool axes, mm.
    pub ball_in_tool_mm: Point3<f64>,
    /// The artefact when nobody calibrated it: its balls are off their nominal places.
    pub uncalibrated: Option<SimForm>,
    /// Places of an artefact, whose origin is at `ball_in_table_mm`; empty: that point itself.
    pub targets: Vec<SimTarget>,
}

impl SimSetup {
    /// A setup with its ball at the tool point and one target.
    pub fn new(
        name: impl Into<String>,
        nest: NestOn,
        ball_in_table_mm: Point3<f64>,
        instrument: Instrument,
    ) -> Self {
        let ball_in_tool_mm = Point3::origin();
        let (targets, uncalibrated) = (Vec::new(), None);
        Self { name: name.into(), nest, ball_in_table_mm, instrument, ball_in_tool_mm, uncalibrated, targets }
    }
}

/// An uncalibrated artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct SimForm {
    /// Its name: the same artefact has the same form in every setup.
    pub name: String,
    /// How it stands.
    pub table_from_artefact: UnitQuaternion<f64>,
}

/// One place of an artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct SimTarget {
    /// Nominal place, table axes, mm.
    pub in_table_mm: Point3<f64>,
    /// Outward normal of a face, table axes; zero for a ball.
    pub normal: Vector3<f64>,
}

/// What carries the nest of the R-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NestOn {
    /// The table; the ball rides in the spindle (S1).
    Table,
    /// The spindle; the ball sits on the table (S0).
    Spindle,
}

/// The instrument between tool and table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// What files call it.
    pub kind: InstrumentKind,
    /// Calibrated length of a bar, mm.
    pub length_mm: f64,
    /// Nominal lengths of two arms, mm.
    pub arms_mm: [f64; 2],
    /// Nominal direction.
    pub direction: Vector3<f64>,
}

impl Instrument {
    /// Three probes around a ball.
    pub const R_TEST: Self = Self::new(InstrumentKind::RTest);

    /// A bar of this length.
    pub const fn ball_bar(length_mm: f64) -> Self {
        Self { length_mm, ..Self::new(InstrumentKind::BallBar) }
    }

    /// An instrument without lengths of its own, along X.
    pub const fn new(kind: InstrumentKind) -> Self {
        Self { kind, length_mm: 0.0, arms_mm: [1.0, 1.0], direction: Vector3::new(1.0, 0.0, 0.0) }
    }

    /// How many numbers it reads.
    pub fn components(self) -> usize {
        self.kind.components().len()
    }
}

/// A setup and how far off it was really placed.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSetup {
    /// As planned.
    pub setup: SimSetup,
    /// Offset of ball against nest, fixed to the table, table axes, mm.
    pub setting_mm: Vector3<f64>,
    /// What else is off about the mounting.
    pub own: Own,
    /// Actual minus nominal place of each target in the artefact, table axes, mm; empty when calibrated.
    pub form_mm: Vec<Vector3<f64>>,
}

/// What is off about an instrument and its mounting other than its place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Own {
    /// Turn of an artefact or of the axes of a tracker about its origin, table axes, rad.
    pub turn_rad: Vector3<f64>,
    /// Zero of a length or radius of a stylus or tool, mm.
    pub zero_mm: f64,
    /// Lengths of arms, actual minus nominal, mm.
    pub arms_mm: [f64; 2],
    /// Zeros of joint angles, rad.
    pub joints_rad: [f64; 2],
    /// Place of a reflector, actual minus nominal, tool axes, mm.
    pub reflector_mm: Vector3<f64>,
    /// What is clamped in a spindle that is a joint: off the spindle's line, tool axes with the spindle at zero, mm.
    pub off_spindle_mm: Vector3<f64>,
    /// Small turn of beam and of mirror, machine axes, rad.
    pub beam_rad: Vector3<f64>,
    /// Of the mirror.
    pub mirror_rad: Vector3<f64>,
}

impl PlacedSetup {
    /// A setup that is off its place only.
    pub fn new(setup: &SimSetup, setting_mm: Vector3<f64>) -> Self {
        Self { setup: setup.clone(), setting_mm, own: Own::default(), form_mm: Vec::new() }
    }
}
