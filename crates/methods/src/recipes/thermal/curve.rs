//! How fast a curve settles: `c + a (1 − e^(−t/τ))` by weighted least squares for each τ tried, the best of them and its interval.

use nalgebra::{Matrix2, Vector2};

/// One number of one round.
pub(super) struct Moment {
    pub time_s: f64,
    pub value: f64,
    pub u: f64,
}

/// Values of τ tried, from a thirtieth of the run to three times its length, each by the same factor longer.
const TRIED: u32 = 400;
const SHORTEST: f64 = 1.0 / 30.0;
const LONGEST: f64 = 3.0;
/// A way this many times its uncertainty has a shape.
const SEEN: f64 = 3.0;

/// Time constant and its standard uncertainty, s; `None` where the curve shows none.
pub(super) fn settled(moments: &[Moment]) -> Option<(f64, f64)> {
    let began_s = moments.first()?.time_s;
    let span_s = moments.last()?.time_s - began_s;
    let freedom = moments.len().checked_sub(3).filter(|&freedom| freedom > 0)? as f64;
    let tried: Vec<(f64, Way)> = (0..=TRIED)
        .filter_map(|k| {
            let tau_s = span_s * SHORTEST * (LONGEST / SHORTEST).powf(f64::from(k) / f64::from(TRIED));
            Some((tau_s, way(moments, began_s, tau_s)?))
        })
        .collect();
    let (best_s, best) = tried.iter().min_by(|(_, a), (_, b)| a.chi_squared.total_cmp(&b.chi_squared))?;
    let scale = (best.chi_squared / freedom).max(1.0);
    if best.size.abs() < SEEN * best.u_size * scale.sqrt() {
        return None;
    }
    let inside = |(_, way): &&(f64, Way)| way.chi_squared <= best.chi_squared + scale;
    let low_s = tried.iter().find(inside)?.0;
    let high_s = tried.iter().rev().find(inside)?.0;
    let bounded = low_s > tried.first()?.0 && high_s < tried.last()?.0;
    bounded.then_some((*best_s, 0.5 * (high_s - low_s)))
}

/// The fit for one τ.
struct Way {
    chi_squared: f64,
    size: f64,
    u_size: f64,
}

fn way(moments: &[Moment], began_s: f64, tau_s: f64) -> Option<Way> {
    let row =
        |moment: &Moment| Vector2::new(1.0, 1.0 - (-(moment.time_s - began_s) / tau_s).exp()) / moment.u;
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for moment in moments {
        let row = row(moment);
        normal += row * row.transpose();
        right += row * (moment.value / moment.u);
    }
    let covariance = normal.try_inverse()?;
    let solution = covariance * right;
    let missed = |moment: &Moment| moment.value / moment.u - row(moment).dot(&solution);
    let chi_squared = moments.iter().map(|moment| missed(moment).powi(2)).sum();
    Some(Way { chi_squared, size: solution.y, u_size: covariance[(1, 1)].sqrt() })
}
