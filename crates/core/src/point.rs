//! One point: what was read at one state of the machine.

use crate::State;

/// How far a point can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Settled within the limits of the cycle.
    #[default]
    Good,
    /// Never settled within the time limit; kept, marked, not fitted.
    Unsettled,
    /// Nothing was read.
    NoReading(Lacks),
}

/// Why nothing was read at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lacks {
    /// Nobody says it: a recording of an older version.
    #[default]
    Unsaid,
    /// The machine never dwelt there: it dwelt at a later pose next.
    Dwell,
    /// The machine stood there, and not every probe had values: one reported errors or was absent, or the dwell was too short.
    Value,
    /// The cycle ended before.
    End,
}

/// One point of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// State of the machine, with the index of the setup.
    pub state: State,
    /// Reading in nest axes, mm: x, y, z of the R-test; the first component alone of a ball bar.
    pub reading_mm: [f64; 3],
    /// Robust spread of the samples behind the reading, mm, for a block on the fly widened by their correlation so that
    /// spread/√samples is the standard error of the reading; zero when unknown.
    pub spread_mm: [f64; 3],
    /// How many samples are behind it; 0 when imported.
    pub samples: u32,
    /// How far it can be trusted.
    pub quality: Quality,
}

impl Point {
    /// Whether identification may use it.
    pub fn is_good(&self) -> bool {
        self.quality == Quality::Good
    }

    /// Standard error of the reading by what its samples say, mm; zero when unknown. What moves all samples of a
    /// point by the same amount (drift, positioning) is not in it.
    pub fn standard_error_mm(&self) -> [f64; 3] {
        let root = f64::from(self.samples.max(1)).sqrt();
        self.spread_mm.map(|spread| if spread.is_finite() { spread / root } else { 0.0 })
    }
}
