//! Multilateration: places of targets by their distances from four stations or more, without a model of the machine.
//!
//! Station j at X_j with dead path z_j reads l_ij of target i at x_i, table axes:
//!     min over x, X, z of Σ (‖x_i − X_j‖ − z_j − l_ij)²
//! [S2 §3.5 eq. 8, which takes differences from the first target instead of z_j: its noise is then in all of them]. Gauss–Newton from the nominal
//! places; targets are eliminated one by one. Place and turn of all together are fixed by the least squares of x_i against the commanded places,
//! so Δ_i = x_i − commanded is the volumetric error but for six rigid motions. u by the residuals: s² = Σ r²/(readings − unknowns + 6), with the
//! rigid fit propagated.
//! Needs 4 stations: n stations and m targets give n m readings for 4 n + 3 m − 6 unknowns. Stations in one plane leave them undetermined.
//! Limits: one noise for all readings; stations at rest; a drift between stations is in no u; angles of the spindle only as far as they move the
//! reflector; air and wavelength compensated before.

mod normal;
mod observed;
mod report;
mod solve;
mod uncertainty;

use super::{Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "multilateration",
    title: "Multilateration: volumetric error at each target, without a model of the machine",
    source: "S2 (Ibaraki & Knapp 2012) §3.5, eq. 8",
    about: "Distances from four stations or more give the places of the stations, their dead paths and the place of every target. \
            Its distance from the commanded place is the volumetric error there.",
    takes_axis: false,
    takes_convention: false,
    needs: "distances of a tracker from four stations or more, not in one plane, to ten targets or more that each of four stations saw",
    gives: "ΔX, ΔY, ΔZ of every target with u, their ranges; places of the stations and dead paths; noise of a reading",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let observed = observed::recognised(&METHOD, runs)?;
    let solved =
        observed.groups.iter().map(|group| solve::solved(&METHOD, group)).collect::<Result<Vec<_>, _>>()?;
    Ok(report::findings(&METHOD, runs, options, &observed, &solved))
}
