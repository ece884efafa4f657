//! Error motions and location errors of one rotary axis from readings at two heights of the ball.
//!
//! Only the axis turns. With (u, v, w) across and along it (C: X Y Z, B: Z X Y, A: Y Z X), ball at height h, turned by θ:
//!     (u, v)(θ) = c + R(θ) s + m(θ)        s setting error (turns with the axis), c place of the axis line, m error motion
//!     E_v0(tilt) = (c_u high − c_u low)/Δh,  E_u0(tilt) = −(c_v high − c_v low)/Δh,  E_u0 = c_u − E_v0 h,  E_v0 = c_v + E_u0 h
//!     tilt_v(θ) = (m_u high − m_u low)/Δh,   tilt_u(θ) = −(m_v high − m_v low)/Δh,   radial_u = m_u − tilt_v h,  radial_v = m_v + tilt_u h
//! s and c by least squares over u and v together, all passes of a height; m averaged over passes both ways
//! [S0 (Kenno 2020) §4.3, eq. 1–3; docs/design/physics.md §3]. More than two heights: the straight line through them.
//! `--convention source` gives S0's signs: its EXC, EYC, EZC (eq. 1–2) and its EA0C (eq. 3) oppose the right-handed ones.
//! Several runs with both heights each are evaluated one by one too (`each_run`): what differs between them is no error of one machine.
//! Limits: the positioning error of the axis is not observable with the ball on its line; an error motion in u, v that turns
//! once with the axis counts as setting; a constant along w counts as setting. What carries the axis is in its location
//! errors: at B = 0 the EB0C found here contains EB0B.

mod charts;
mod circle;
mod each_run;
mod error_motions;
mod fit;
mod under_noise;
mod values;

use super::{Method, MethodError, MethodOptions};
use crate::Findings;
use crate::common::lone;
use crate::common::turning::Turning;
use fit::Heights;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "two-height",
    title: "Error motions and location errors of one rotary axis from two heights",
    source: "S0 eq. 1-3; docs/design/physics.md §3",
    about: "Only one rotary axis turns, the ball sits near its line at two heights. Least squares separate \
            the circle of a ball set off the axis, the location of the axis line, and the residual (the error motions).",
    takes_axis: true,
    takes_convention: true,
    needs: "an R-test at two heights of the ball near the axis line; one rotary axis turning alone by 90° or more, best two \
            turns both ways",
    gives: "setting errors, the four location errors of the axis, five error motions over its angle",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    let (kept, outliers) = lone::without_outliers(runs);
    let turning = Turning::of(&METHOD, &kept, options.axis)?;
    let heights = Heights::of(&METHOD, &turning)?;
    let each = each_run::evaluated(&METHOD, &turning, runs);
    let u = under_noise::u_of_lines(&kept, &heights)?;
    let found = values::findings(&METHOD, &turning, &heights, &each, u.as_deref(), runs, options.convention);
    Ok(lone::named(found, &outliers, runs, "The method"))
}
