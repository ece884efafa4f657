//! A bar of calibrated length that reads farther from it than balls set by hand are: said with the first point of its setup.

use trunnion_core::number::signed;
use trunnion_core::setup::SET_BY_HAND_MM;
use trunnion_core::{Point, Quality, Setup};

/// Looks at the first good point of each setup.
#[derive(Debug, Default)]
pub(super) struct BarLength {
    looked: Vec<usize>,
}

impl BarLength {
    /// What to say of a point.
    pub(super) fn doubt(&mut self, setups: &[Setup], point: &Point) -> Option<String> {
        let index = point.state.setup;
        let setup = setups.get(index).filter(|setup| setup.reads_calibrated_length())?;
        if point.quality != Quality::Good || self.looked.contains(&index) {
            return None;
        }
        self.looked.push(index);
        let off_mm = point.reading_mm[0];
        let length_mm = setup.bar_length_mm.unwrap_or_default();
        (off_mm.abs() > SET_BY_HAND_MM).then(|| {
            format!(
                "Setup {}: the bar reads {} mm from its calibrated length of {length_mm} mm, farther than balls set by hand are. \
                 Its zero_mm is wrong by so much, or another bar is in, and nothing can be judged by its length: put the bar on its calibrator, \
                 correct zero_mm (or bar_length_mm of the cycle), and measure again.",
                setup.name,
                signed(off_mm, 2)
            )
        })
    }
}
