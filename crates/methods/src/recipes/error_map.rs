//! Error map of two stacked rotary table axes from static R-test poses at two nest positions.
//!
//! Table-side readings in table axes, tilting axis B at B_i, turning axis C at C_j, nest at p_s, all small:
//!     d(i, j, s) = o_s − R_tᵀ [ R δ_B + (R ω_B) × (p − o_B) ](B_i) − R_tᵀ [ R δ_C + (R ω_C) × (p − o_C) ](B_i, C_j)
//! 1. The six errors (δ_B, ω_B) of each B index by least squares over all C and all nest positions, those of C taken as
//!    zero [S1 (Oyama) eq. 10–15]. Only changes from the first pose are measured: S1 subtracts the reading there (eq. 14); here the
//!    offset o_s of each nest position is solved for together with the errors at all B indices (docs/design/physics.md §4), so that
//!    the noise of one reading does not enter all others.
//! 2. The errors of C at each pose: tilts from the line between the nest positions, then translations, ECC taken as zero
//!    [S1 eq. 16–22].
//! 3. The map as constants: location errors of both axes by least squares over the B indices, next to those of the joint fit.
//!    An offset of the zero pose along and about C is no error of B; of all B maps that differ by it the one is shown that these
//!    constants explain best.
//!
//! Signs follow docs/design/physics.md §4 and §8: S1 eq. 8–9 carry the opposite sign of its eq. 4. `--convention source` shows S1's names and
//! signs as its Fig. 6–7 do, which are the same as the right-handed ones (errors of the axes, not of the readings).
//! Limits: linear axes free of error; errors of C at a pose that are alike at all C of a B index count as errors of B;
//! an angular positioning error of C counts as the other errors that resemble it.

mod b_errors;
mod c_errors;
mod charts;
mod components;
mod found;
mod grid;
mod location;
mod nest_calibration;
mod tilting;
mod values;

use found::Found;

use super::{Method, MethodError, MethodOptions};
use crate::Findings;
use b_errors::BErrors;
use c_errors::CErrors;
use grid::Grid;
use location::Locations;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::{Experiment, Problem};

pub(super) static METHOD: Method = Method {
    name: "error-map",
    title: "Error map of both rotary axes of a tilting rotary table",
    source: "S1 eq. 1-23; docs/design/physics.md §4, §8",
    about: "Readings at rest over a grid of both rotary axes are taken at two nest positions. They give the six errors of the \
            tilting axis at each of its angles and five errors of the turning axis at each pose; next to it the joint fit of the same readings.",
    takes_axis: false,
    takes_convention: true,
    needs: "R-test readings at rest over a grid of two stacked rotary table axes (S1: B −90..90° and C 0..330° in steps of 30°) \
            at two nest positions of different height",
    gives: "six errors of the tilting axis over its angle, five of the turning axis at each pose; location errors by maps and \
            by the joint fit, maps and overlays",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    let (calibration, calibrated) = nest_calibration::apply(runs);
    let runs = calibrated.as_slice();
    let grid = Grid::of(&METHOD, runs)?;
    let b_errors = BErrors::of(&METHOD, &grid)?;
    let c_errors = CErrors::of(&grid, &b_errors);
    let experiment = Experiment::of_points(runs)?;
    let problem = Problem::new(&experiment, &Model::base(&grid.machine.name))?;
    let locations = Locations::of(&grid, &b_errors, problem.fit()).under_noise(&problem)?;
    let b_errors = b_errors.without_datum(&locations.datum);
    let joint = problem.into_fit();
    let found = Found { grid: &grid, b_errors, c_errors, locations, joint, calibration };
    Ok(values::findings(&METHOD, runs, &found, options))
}
