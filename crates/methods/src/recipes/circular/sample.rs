//! One reading of a circle.

/// One reading.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    /// φ, −π…π.
    pub angle_rad: f64,
    /// d: +1 counter-clockwise (from the first letter to the second), −1 clockwise.
    pub way: f64,
    /// Reading less that of the nominal machine, mm.
    pub deviation_mm: f64,
    /// Of a and b: ±1 by the way the tool moves against the table along the letter.
    pub direction: [f64; 2],
    /// What is known of the last reversal of a and b.
    pub reversal: [Reversal; 2],
    /// Commanded positions of a and b, mm.
    pub position_mm: [f64; 2],
    /// Speed along the path, mm/s; zero when the run does not show it.
    pub speed_mm_per_s: f64,
}

/// The last reversal of one axis before one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reversal {
    /// Travel since, mm.
    Since(f64),
    /// Not known: the number of the beginning, and the travel since, mm.
    Unknown { beginning: usize, travel_mm: f64 },
}
