//! The key `zero_mm` of a ball bar: what its device shows while the bar is as long as its cycle says.
//!
//! A device counts from a zero of its own. Changes of length need none; where a length is calibrated, this says from where it counts.

use trunnion_core::Role;
use trunnion_core::input::Table;

/// Farthest zero, mm: the longest displacement that a driver reads.
const FARTHEST_MM: f64 = 1000.0;

/// Reads the key, noting problems; `None` where nobody says it, and for whatever is no bar.
pub(crate) fn read(table: &Table<'_>, role: Option<Role>) -> Option<f64> {
    (role == Some(Role::Bar)).then(|| table.optional_number("zero_mm", -FARTHEST_MM..=FARTHEST_MM)).flatten()
}
