//! Readings of a ball bar to first order in how far its balls sit off.
//!
//! b from the table's ball to the tool's on the nominal machine, L = ‖b‖, n = b/L; e what the one is off against the other. The bar reads
//!     ‖b + e‖ − L = n·e + (e² − (n·e)²)/2L + …
//! Errors of a machine are µm, for which n·e is enough; a ball is set by hand, often 0.2 mm off: at L = 100 mm the second term is 0.2 µm, a
//! mean and an oval. It is taken off with the e that the readings themselves show, which is found again from what that leaves.
//! Limits: of e that part which the readings show.

use nalgebra::{DVector, Vector3};

/// Each round leaves of the second term a share e/L of the round before: of 1 mm at 50 mm the third less than 1 nm.
const ROUNDS: usize = 3;
/// Relative singular value below which a direction of e is not determined well enough to take anything off by it.
pub(crate) const OFF_TOLERANCE: f64 = 1e-2;

/// What a bar reads, ‖b + e‖ − ‖b‖, mm.
pub(crate) fn read_mm(bar_mm: &Vector3<f64>, off_mm: &Vector3<f64>) -> f64 {
    (bar_mm + off_mm).norm() - bar_mm.norm()
}

/// The same less its first order, n·e, mm.
fn beyond_first_order_mm(bar_mm: &Vector3<f64>, off_mm: &Vector3<f64>) -> f64 {
    read_mm(bar_mm, off_mm) - bar_mm.dot(off_mm) / bar_mm.norm()
}

/// Readings (mm) as they would be if they were n·e. `off_mm` finds the e of each reading from such readings.
pub(crate) fn to_first_order(
    read_mm: &DVector<f64>,
    bars_mm: &[Vector3<f64>],
    off_mm: impl Fn(&DVector<f64>) -> Vec<Vector3<f64>>,
) -> DVector<f64> {
    let mut first_order_mm = read_mm.clone();
    for _ in 0..ROUNDS {
        let beyond = bars_mm.iter().zip(off_mm(&first_order_mm));
        let beyond = beyond.map(|(bar_mm, off_mm)| beyond_first_order_mm(bar_mm, &off_mm));
        first_order_mm = read_mm - DVector::from_iterator(read_mm.len(), beyond);
    }
    first_order_mm
}
