//! Error motion values of a rotary axis: radial, axial, tilt; total, synchronous, asynchronous.
//!
//! Definitions [restated from ISO 230-7:2015, Axes of rotation, clause 3], for the signal s_p(θ) of turn p:
//! - least-squares centre: `s̄ + a cos θ + b sin θ` fitted to all turns of one direction and taken off; what remains is d_p(θ).
//!   The once-a-turn part is the eccentricity of the artefact and is no radial or tilt error motion; of the axial motion it is the
//!   fundamental, which is given next to it;
//! - *total* error motion value: difference of the radii of the two circles about that centre that just hold all turns,
//!   `max d − min d`;
//! - *synchronous* value: the same of what recurs in every turn (whole multiples of the frequency of rotation), the mean contour:
//!   `max d̄ − min d̄`, d̄(θ) the mean over the turns;
//! - *asynchronous* value: the largest width of the plot along a radius, `max_θ (max_p d − min_p d)`.
//!
//! Sensitive directions of the radial motion: fixed along u and v (X and Y for C), and rotating with the axis,
//! `u cos θ + v sin θ`. Tilt: the difference of two heights over their distance. Each direction of turning counts by itself, the
//! larger value is the result; *reversal* is the largest distance of the mean contours of both directions.
//! Readings that a fit of the base model excludes as single wrong ones count in no value, and are named: one of them would be every total value.
//! Limits: between stations (1° at the finest) the signal is averaged, so lobes beyond about 100 a turn are damped; two heights
//! read one after the other give a tilt whose total and asynchronous values are upper bounds; a single turn gives the total alone.

mod contour;
mod report;

use super::{Method, MethodError, MethodOptions};
use crate::Findings;
use crate::common::lone;
use crate::common::turning::Turning;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "rotary-values",
    title: "Error motion values of a rotary axis: total, synchronous, asynchronous",
    source: "ISO 230-7:2015, clause 3 (definitions)",
    about: "Only one rotary axis turns, several times. About the least-squares centre: how far the axis strays in all, what \
            repeats in every turn, and what does not, for radial, axial and tilt motion.",
    takes_axis: true,
    takes_convention: false,
    needs: "an R-test with the ball near the axis line; one rotary axis turning alone by 90° or more; several whole turns in one \
            direction (at least two to separate synchronous from asynchronous); a second height for the tilt",
    gives: "total, synchronous and asynchronous values of the radial (fixed and rotating direction), axial and tilt error motion",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    let (kept, outliers) = lone::without_outliers(runs);
    let turning = Turning::of(&METHOD, &kept, options.axis)?;
    let found = report::findings(&METHOD, &turning, runs, options.convention)?;
    Ok(lone::named(found, &outliers, runs, "ISO 230-7"))
}
