//! How one axis moves at a row.

/// Speed and acceleration at the row, and the way to its neighbours on the path.
#[derive(Clone, Copy, Default)]
pub(super) struct Moving {
    /// Time (negative, s) and way from the row before it.
    pub back: Option<(f64, f64)>,
    /// Way to the row after it.
    pub ahead: Option<f64>,
    pub speed: f64,
    pub acceleration: f64,
}
