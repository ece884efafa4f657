//! Errors split into a quasi-static and a feed-dependent part, from one cycle at several feeds.
//!
//! p_k = q + r w_k + s w_k f_k + a f_k² + ε_k        [Andolfatto 2011: quasi-static errors do not depend on the speed, dynamic ones do]
//! p_k: location errors and settings of the base model, fitted to sweep k alone; w_k = ±1 its way; f_k its feed over the fastest one.
//! q and r do not depend on the feed: geometry, and what changes with the direction (backlash). s is proportional to the speed and flips with the
//! way (lag, delay); a is proportional to f², as accelerations on one path are. With one way, s is the part ∝ f, and a needs a third feed.
//! Least squares, every sweep alike; with ν = sweeps − parts degrees of freedom, u = t(0.95; ν)/1.96 · s_ε √C_jj, so that ± 1.96 u holds 95 %
//! [Abramowitz 1964 §26.7]. u of q is no smaller than under the noise that all readings show together (`noise`): the sweeps' scatter does not show what
//! moves all of them. An error depends on the feed where s or a is beyond its t at 5 % over all of them (Bonferroni).
//! Limits: on the fly, one rotary axis or a path of linear axes at constant feeds; what drifts while the feeds follow one another passes for a part of the feed; what the base model
//! does not describe stays in the residual, which is given by feed.

mod noise;
mod read;
mod report;
mod split;
mod sweeps;

use super::{Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "quasi-static",
    title: "Quasi-static and feed-dependent parts of each error",
    source: "Andolfatto 2011",
    about: "One path at several feeds, both ways. Each error is split: what stays at every feed, what changes with the direction, what grows \
            with speed, and what with acceleration.",
    takes_axis: true,
    takes_convention: false,
    needs: "runs on the fly of one cycle at two feeds or more (feeds_deg_per_min, feeds_mm_per_min), both ways, with one sweep more than parts: \
            three feeds, or each feed twice",
    gives: "location errors and settings, each as quasi-static part and parts with the direction, speed and acceleration at the fastest feed, with u",
    run,
};

fn run(runs: &[Run], options: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let sweeps = sweeps::fitted(&METHOD, runs, options.axis)?;
    let parts = split::parts(&METHOD, runs, &sweeps)?;
    Ok(report::findings(&METHOD, runs, &sweeps, &parts))
}
