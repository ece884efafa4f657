//! The cycle that was chosen, as a diagnosis carries it.

/// A cycle that separates rivals, with what may be expected of it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedCycle {
    /// Its name.
    pub name: String,
    /// What it does, in words.
    pub what: String,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// log₁₀ of the expected odds between the hardest pair in the present data.
    pub separation_before: f64,
    /// The same after the cycle.
    pub separation: f64,
    /// Pairs of effects that it distinguishes.
    pub separates: Vec<[String; 2]>,
    /// The cycle file, `trunnion-cycle/1`.
    pub text: String,
}
