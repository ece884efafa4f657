//! A sample on its way into cells, and the units of its axes.

use trunnion_core::axis::SLOTS;
use trunnion_core::{AxisValues, Point, Slot};

/// Travel that counts as one unit: 2 mm and 1° (rad).
pub(crate) const UNIT: AxisValues<f64> = {
    let degree = std::f64::consts::PI / 180.0;
    let mut unit = [2.0; SLOTS];
    let mut k = 0;
    while k < SLOTS {
        if Slot::ALL[k].is_rotary() {
            unit[k] = degree;
        }
        k += 1;
    }
    AxisValues(unit)
};

/// Width of a block before any merging, units.
pub(crate) const FINEST: f64 = 0.125;

/// One sample on its way into a block.
pub(crate) struct Sample {
    pub index: u64,
    pub point: Point,
    /// Reading − nominal reading, mm.
    pub departure_mm: [f64; 3],
}
