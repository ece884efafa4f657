//! Axes as controllers name them.

use trunnion_core::Joint;

/// Axis named by a component or data item: `C`, `C1`, `c`; `S` and others are none.
pub(crate) fn letter_of(name: &str) -> Option<Joint> {
    Joint::parse(name.trim_end_matches(|c: char| c.is_ascii_digit()))
}
