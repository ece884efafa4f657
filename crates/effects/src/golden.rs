//! Golden cases: what an R-test reads of an effect, by a publication or by a formula of one worked by hand.
//!
//! Machine table-bc, nest on the table, readings in table axes: R_table⁻¹ (d_tool − d_table). A case proves sign, unit, frame
//! and site of an effect with a number that this program did not compute.

/// A case whose answer comes from outside this program.
pub struct Golden {
    /// Standard, paper, data sheet or table, with the place in it.
    pub source: &'static str,
    /// How the readings follow from it: a line or two that a person can check by hand.
    pub derivation: &'static str,
    /// Id on machine table-bc.
    pub id: &'static str,
    /// Shape numbers, inside units.
    pub shape: &'static [f64],
    /// Parameters that are not zero: name and value on the screen.
    pub values: &'static [(&'static str, f64)],
    /// Nominal centre of the table-side ball in table axes, mm: of setup `low`, then of setup `high`.
    pub balls_mm: &'static [[f64; 3]],
    /// What the machine does, in time order; together they are the scene.
    pub moments: &'static [Moment],
    /// Half of the last digit that the source gives, µm.
    pub within_um: f64,
}

/// Values of axes that are not zero, by letter.
pub type ByAxis = &'static [(&'static str, f64)];

/// One state of the machine and what is read there.
pub struct Moment {
    /// Positions, mm and degrees.
    pub position: ByAxis,
    /// Directions of approach, −1 or +1.
    pub direction: ByAxis,
    /// Velocities, mm/s and degrees/s.
    pub velocity: ByAxis,
    /// Accelerations, mm/s² and degrees/s².
    pub acceleration: ByAxis,
    /// Travel since the last reversal, mm and degrees.
    pub since_reversal: ByAxis,
    /// Seconds since the run began.
    pub time_s: f64,
    /// Value of the one temperature channel, `frame`, °C.
    pub frame_degc: f64,
    /// Deflection of the probes, nest axes, mm.
    pub deflection_mm: [f64; 3],
    /// Index of the setup.
    pub setup: usize,
    /// Index of the target of the plate.
    pub target: usize,
    /// What the effect adds to the reading, table axes, µm; `None` where the moment only belongs to the scene.
    pub read_um: Option<[f64; 3]>,
}

impl Moment {
    /// All axes at zero and at rest, at time 0 and 20 °C; nothing expected.
    pub const AT_REST: Self = Self {
        position: &[],
        direction: &[],
        velocity: &[],
        acceleration: &[],
        since_reversal: &[],
        time_s: 0.0,
        frame_degc: 20.0,
        deflection_mm: [0.0; 3],
        setup: 0,
        target: 0,
        read_um: None,
    };
}
