//! What a report shows: plain data, whoever computed it.

use nalgebra::{Matrix3, Vector3};
use trunnion_core::{AxisLetter, AxisValues};
use trunnion_engine::compare::Place as WorstPlace;
use trunnion_results::{Diagnosis, Identification, Moved, Parameter, TimeQuality};

/// Everything the compare report shows. Empty lists and `None` leave their section out or say what is missing.
#[derive(Clone, Debug, Default)]
pub struct CompareInput {
    /// The fit, with its parameters.
    pub identification: Identification,
    /// The repeatability.
    pub noise: Noise,
    /// Date, software version or whatever else the caller wants under the headline; may be empty.
    pub label: String,
    /// Setups; `PointView::setup` indexes them.
    pub setups: Vec<SetupView>,
    /// Points in the order they were taken.
    pub points: Vec<PointView>,
    /// Of long runs only every n-th point is in `points`; 1 or 0: all are.
    pub every: usize,
    /// True when the points were sampled while an axis turned.
    pub on_the_fly: bool,
    /// Rotary joints of the machine.
    pub rotary: Vec<AxisLetter>,
    /// Where the model fails most, worst first; empty when no place stands out of the noise.
    pub places: Vec<WorstPlace>,
    /// The list of effects added, with the error after each.
    pub ladder: Vec<LadderRow>,
    /// Which effect is missing, when that was asked.
    pub diagnosis: Option<Diagnosis>,
    /// The best candidate, or the one a user asked for, put in for a trial.
    pub trial: Option<Trial>,
    /// What is missing from the recording, one sentence each (gaps, damaged parts, points never settled).
    pub losses: Vec<String>,
    /// How well each run is known in time.
    pub timing: Vec<TimeQuality>,
}

/// An effect put into the model for a trial: the fits without and with it.
#[derive(Clone, Debug, Default)]
pub struct Trial {
    /// Effect id.
    pub effect: String,
    /// `dz at axis:B: k*sin(2*B)` for a formula; empty otherwise.
    pub expression: String,
    /// Residual of the fit without and with it, µm rms.
    pub fit_um: [f64; 2],
    /// Held-out residual without and with it, µm rms.
    pub holdout_um: [Option<f64>; 2],
    /// The repeatability.
    pub noise: Noise,
    /// Parameters of the effect.
    pub parameters: Vec<Parameter>,
    /// Parameters of the other effects that move when it comes in.
    pub moved: Vec<Moved>,
    /// Where the model fails most, without and with it.
    pub places: [Vec<WorstPlace>; 2],
    /// Points as predicted without and with it.
    pub points: [Vec<PointView>; 2],
    /// What the diagnosis says of the model with it.
    pub then: Option<Diagnosis>,
}

/// Repeatability of a reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise {
    /// µm rms per component; `None` when the cycle has nothing to estimate it from.
    pub rms_um: Option<f64>,
    /// Where the figure comes from, e.g. "both directions at the same pose".
    pub origin: String,
}

/// One instrument mounted in one way, as shown.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupView {
    /// Name, e.g. `low`.
    pub name: String,
    /// Names of the components of a reading: x y z, or r.
    pub components: Vec<String>,
    /// Nominal centre of the table-side ball or nest, table axes, mm.
    pub ball_in_table_mm: Vector3<f64>,
}

/// One point: where it was, what was read, what the model says.
#[derive(Clone, Debug, PartialEq)]
pub struct PointView {
    /// Index of its setup.
    pub setup: usize,
    /// Commanded axis positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Direction of each axis in the pass that the point belongs to: −1, 0 (unknown), +1. Where a pass turns round, the
    /// few poses approached from the other side stay with it.
    pub direction: AxisValues<f64>,
    /// Seconds since the run began.
    pub time_s: Option<f64>,
    /// Reading, nest axes, mm; only the first component of a ball bar.
    pub measured_mm: [f64; 3],
    /// What the model predicts for it, mm.
    pub predicted_mm: [f64; 3],
    /// True when the robust loss set it aside.
    pub outlier: bool,
    /// The table-side ball or nest in machine axes.
    pub in_machine: Place,
    /// The same in the axes of the part that carries the turning axis, Z along that axis: the table plane is its XY plane.
    pub in_table_plane: Place,
    /// Rotation from machine to table axes.
    pub table_from_machine: Matrix3<f64>,
}

/// A commanded place, and how a reading moves it: `actual = commanded + shift_from_reading · reading`.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Commanded place of the table-side ball or nest, mm.
    pub commanded_mm: Vector3<f64>,
    /// Motion of the table side against the tool per reading, in the axes of this place.
    pub shift_from_reading: Matrix3<f64>,
}

/// One step of the ladder: an effect added, and the error before and after.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LadderRow {
    /// Effect added; the first row may be the base model.
    pub effect: String,
    /// Date as written in the model file; may be empty.
    pub date: String,
    /// Run it was fitted to; may be empty.
    pub run: String,
    /// Residual of the fit before, µm rms.
    pub fit_before_um: f64,
    /// Residual of the fit after, µm rms.
    pub fit_after_um: f64,
    /// Held-out residual before, µm rms.
    pub holdout_before_um: Option<f64>,
    /// Held-out residual after, µm rms.
    pub holdout_after_um: Option<f64>,
    /// Repeatability at this step, µm rms.
    pub noise_um: Option<f64>,
    /// Parameters of the effects before it that moved when it came in, most moved first.
    pub moved: Vec<Moved>,
}

impl PointView {
    /// `measured − predicted`, nest axes, mm.
    pub fn residual_mm(&self) -> Vector3<f64> {
        Vector3::from(self.measured_mm) - Vector3::from(self.predicted_mm)
    }

    /// The residual as motion of the tool against the table, machine axes, mm; for instruments of three components.
    pub fn tool_residual_mm(&self) -> Vector3<f64> {
        -(self.in_machine.shift_from_reading * self.residual_mm())
    }
}
