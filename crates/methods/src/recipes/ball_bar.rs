//! Location errors and error motions of rotary axes from a ball bar (DBB5), and the circularity of every trace.
//!
//! r is the reading less that of the nominal machine, counted along the positive direction of a linear letter: tool against
//! table. The bar of a measurement that one axis turns alone is read as the place of what the axis carries, −r on the table side.
//! With (u, v, w) across and along the axis (C: X Y Z, B: Z X Y), ball at height h over its reference point, turned by θ:
//!     C-X, C-Y:  u(θ) = c_u + s₁ cos θ + s₂ sin θ + m_u(θ)     c place of the axis line (S4's mean), s setting of the ball, m shape
//!     E_v0 = (c_u high − c_u low)/Δh,  E_u0 = −(c_v high − c_v low)/Δh;  the same of m gives the tilt error motions
//!     C-Z:       w(θ) = c_w + m_w(θ)                                     axial error motion, centred only
//!     C-XY:      w(θ) = c + E_u0 p_v − E_v0 p_u                          p place of the ball: centre of the trace / radius
//!     a path:    r = c + n·t                                             n bar in table axes, t setting of the ball on the table
//! of readings of which the second order of s is taken off where the trace shows s: C-X, C-Y and a path (`common::bar`).
//! [S4 (Ibaraki, DBB5) eq. 1–7, Fig. 6–11; docs/design/physics.md §5]. Circularity: range of what this leaves, mean over each direction.
//! S4's r is the reading with the tool's ball on the positive side: then eq. 4–7 are right-handed as printed; of eq. 1 the number
//! (−4.2 µm/100 mm) and of eq. 2 the formula carries the wrong sign, as does α in δy of eq. 3 [docs/design/physics.md §8.4].
//! `--convention source` prints E_B0C as S4's eq. 1 does, and E_X0C, E_Y0C as eq. 3 (tool against table, the sign of α mended).
//! Limits: a shape that turns once with the axis counts as setting; positioning errors of the axis are not seen; places of the
//! axis line need a bar of known length; a place c of the line across a bar of length L adds c²/2L to its mean; what carries the axis is in its errors. C-XY also sees X, Y and their squareness.

mod causes;
mod charts;
mod dependence;
mod error_motions;
mod found;
mod joint_fit;
mod location;
mod ranking;
mod shape;
mod track;
mod values;

use found::Found;

use super::{Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use shape::{AxisShapes, Shape};
use track::recognised;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::{Experiment, Problem};

pub(super) static METHOD: Method = Method {
    name: "ball-bar",
    title: "Location errors and error motions of rotary axes from a ball bar",
    source: "S4 eq. 1-7; ISO 10791-6 BK2, BK4; docs/design/physics.md §5, §8",
    about: "Each setup is recognised by how its bar lies and what moves: a rotary axis alone with the bar across or along it \
            (C-X, C-Y, C-Z, B-X, B-Z, B-Y); a rotary axis followed by linear ones with the bar along it (C-XY); any other path. \
            Means give location errors, shapes give error motions and circularities; next to them the joint fit.",
    takes_axis: true,
    takes_convention: true,
    needs: "ball-bar readings while a rotary axis turns by 90° or more: alone, with the ball on its line, best at two heights with \
            the bar in both directions across it and along it; or followed by linear axes",
    gives: "location errors of each axis, radial, axial and tilt error motions, circularity of every trace, likely causes ranked over the machine",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let tracks = recognised(&METHOD, runs, options.axis)?;
    let shapes = Shape::of_all(&METHOD, &tracks.all)?;
    let axes = AxisShapes::of_all(&shapes);
    let mut location = location::locations(&shapes, &axes);
    let (mut by_joint_fit, mut noise_is_known) = (Vec::new(), false);
    if !location.is_empty() {
        let experiment = Experiment::of_points(runs)?;
        let problem = Problem::new(&experiment, &Model::base(&experiment.machine().name))?;
        by_joint_fit = joint_fit::locations_of(&METHOD, &problem, options.axis)?;
        noise_is_known = location::under_noise(&mut location, &problem)?;
    }
    let found =
        Found { tracks: &tracks, shapes: &shapes, axes: &axes, location, by_joint_fit, noise_is_known };
    Ok(values::findings(&METHOD, runs, &found, options.convention))
}
