//! Circular tests of two linear axes with a ball bar or a cross-grid encoder: the values of ISO 230-4, and what the trace is made of.
//!
//! Plane (a, b) = XY, YZ or ZX, bar R (cos φ, sin φ) from the table's ball to the tool's, d = ±1 counter-clockwise or clockwise.
//! An error (e_a, e_b) of the tool against the table reads r = e_a cos φ + e_b sin φ. Each error of the classical list is a column;
//! all of them and the centring (1, cos φ, sin φ) are fitted to both directions together by least squares:
//!     squareness ∓γ R sin φ cos φ · scale mismatch ½ (s_a − s_b) R cos 2φ · servo mismatch (τ_a − τ_b) v d sin φ cos φ
//!     backlash e_a = ½ h sgn v_a (h negative where the axis stops short, as in the catalogue) · lateral play e_b = ½ p sgn v_a · reversal spike e_a = −h sgn v_a exp(−travel since reversal / s₀)
//!     cyclic e_a = A cos 2πa/P + B sin 2πa/P (P screw lead) · straightness e_b = w (a/R)²  (three lobes)
//! How far the ball sits off the centre counts beyond first order (`common::bar`). What an axis sticks by at the beginning of a pass is a size of its own
//! (`reversals`). One way, squareness and servo mismatch are one number, and nothing is to be entered.
//! A run that knows no speed v has the servo mismatch as the distance e = (τ_a − τ_b) v, at one unknown speed: left off the list, it would be
//! read as backlash and spikes.
//! [ISO 230-4:2005 clause 3; Kakino, Ihara, Shinohara 1990 (DBB method); docs/design/physics.md §5.2]. Each error's own circularity is the range of
//! what it alone makes of the trace, centred. What all of them leave is given as share of the variance and in µm, next to the
//! noise of the readings by their second differences: more than noise is something the list lacks. What the list lacks may also read as an error
//! of the list; `confounded` says which causes of the catalogue do, and by how far they may move it.
//! Limits: first order in errors over R; mean scale is not distinguished from a bar without calibrated length, nor an error that makes a
//! first lobe from the setting; straightness only as a bow; spikes by one decay s₀ for each axis.

mod charts;
mod confounded;
mod drift;
mod fit;
mod list;
mod planes;
mod plate;
mod reversals;
mod sample;
mod solved;
mod to_do;
mod trace;
mod values;

use super::{Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use fit::Fitted;
use trace::recognised;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "circular",
    title: "Circular tests of linear axes: ISO 230-4 values and the errors behind them, ranked",
    source: "ISO 230-4:2005; Kakino et al. 1990 (DBB); S4 §4.1; docs/design/physics.md §5.2",
    about: "Circles of two linear axes by a ball bar or on a grid plate, best both ways: circular deviations; and the classical list of errors, fitted \
            to both directions together. Each has its own circularity and its rank; the share that nothing on the list explains stands last.",
    takes_axis: false,
    takes_convention: false,
    needs: "a ball bar or a cross-grid encoder while two linear axes make a circle of 180° or more, best whole circles both ways",
    gives: "G of each direction, G(b), D and F (bar of known length, grid plate), squareness, scale mismatch; backlash, reversal spikes, lateral \
            play, cyclic error, servo mismatch, straightness, and what they leave",
    run,
};

fn run(runs: &[Run], _: &MethodOptions) -> Result<Findings, MethodError> {
    let machine = one_machine(runs)?;
    let traces = recognised(&METHOD, runs)?;
    let fits: Vec<Fitted<'_>> =
        traces.all.iter().map(|trace| Fitted::of(&METHOD, machine, trace)).collect::<Result<_, _>>()?;
    Ok(values::findings(&METHOD, machine, runs, &traces, &fits))
}
