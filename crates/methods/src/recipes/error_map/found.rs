//! Everything the steps gave.

use super::b_errors::BErrors;
use super::c_errors::CErrors;
use super::grid::Grid;
use super::location::Locations;
use super::nest_calibration::Calibration;
use trunnion_engine::Identification;

/// Everything the steps gave.
pub(super) struct Found<'a> {
    pub(super) grid: &'a Grid<'a>,
    pub(super) b_errors: BErrors,
    pub(super) c_errors: CErrors,
    pub(super) locations: Locations,
    pub(super) joint: Identification,
    pub(super) calibration: Calibration,
}
