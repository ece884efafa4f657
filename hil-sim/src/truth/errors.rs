//! What is wrong with one machine during one run.

use super::NamedError;
use super::setup::{PlacedSetup, SimSetup};
use crate::physics::hidden::Hidden;
use nalgebra::Vector3;
use trunnion_machine::JointErrors;

/// What is wrong with one machine during one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Name of the machine file.
    pub machine: String,
    /// Seed of everything random that is not written out: noise and natural error motions.
    pub seed: u64,
    /// Length of the run for which the time constants were drawn, s.
    pub run_duration_s: f64,
    /// Location errors at the joints, constant, mm and rad (minimum set, others zero).
    pub location: JointErrors,
    /// The same of joints that are called otherwise than by a letter.
    pub named: Vec<NamedError>,
    /// How far off the line of the spindle a person clamps a ball or nest in it, mm; for machines whose spindle is a joint.
    pub off_spindle_mm: f64,
    /// Setups in the order of `State::setup`.
    pub setups: Vec<PlacedSetup>,
    /// Everything the readings suffer in addition.
    pub noise: Noise,
    /// Physics no base model knows of.
    pub hidden: Vec<Hidden>,
}

/// Noise of a run. Standard deviations unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// White noise of every component of every reading, mm.
    pub white_mm: f64,
    /// Offset of every pass (setup and directions of travel), machine axes, mm.
    pub pass_offset_mm: f64,
    /// Slow Ornstein–Uhlenbeck drift, machine axes, mm.
    pub drift_mm: f64,
    /// Its correlation time, s.
    pub drift_time_s: f64,
    /// Scatter of every positioning of the tilting axis, rad.
    pub repeatability_rad: f64,
    /// Size of the small repeatable error motions every rotary axis has, mm.
    pub natural_motion_mm: f64,
    /// Share of outliers, 0..1.
    pub outlier_share: f64,
    /// Size of an outlier, mm.
    pub outlier_mm: f64,
}

impl Noise {
    /// None at all.
    pub const NONE: Self = Self {
        white_mm: 0.0,
        pass_offset_mm: 0.0,
        drift_mm: 0.0,
        drift_time_s: 600.0,
        repeatability_rad: 0.0,
        natural_motion_mm: 0.0,
        outlier_share: 0.0,
        outlier_mm: 0.0,
    };

    /// White noise of 0.3 µm only.
    pub const WHITE: Self = Self { white_mm: 0.3e-3, ..Self::NONE };

    /// What a good machine in a good room does (docs/design/statistics.md §1.1). The drift wanders over a quarter of the run.
    pub fn real(run_duration_s: f64) -> Self {
        Self {
            white_mm: 0.3e-3,
            pass_offset_mm: 0.1e-3,
            drift_mm: 0.15e-3,
            drift_time_s: 0.25 * run_duration_s,
            repeatability_rad: 1e-6,
            natural_motion_mm: 0.15e-3,
            outlier_share: 0.01,
            outlier_mm: 5e-3,
        }
    }
}

impl Truth {
    /// A machine without any error and without noise.
    pub fn perfect(machine: &str, setups: &[SimSetup], run_duration_s: f64) -> Self {
        let place = |setup: &SimSetup| PlacedSetup::new(setup, Vector3::zeros());
        Self {
            machine: machine.into(),
            seed: 0,
            run_duration_s,
            location: JointErrors::default(),
            named: Vec::new(),
            off_spindle_mm: 0.0,
            setups: setups.iter().map(place).collect(),
            noise: Noise::NONE,
            hidden: Vec::new(),
        }
    }
}
