//! Named effects next to a model: those worth it get the noise learned with them, and their best shape.

use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{Scored, shape_price_ln};
use crate::diagnosis::view::{Item, OnGrid, View, What, evidence_relearned};
use crate::diagnosis::views::Seen;
use crate::evidence::{evidence_of, evidence_of_each, turned};
use nalgebra::DMatrix;
use std::sync::Arc;

/// ln Bayes factors below this are "not worth more than a bare mention" [Kass 1995].
pub const BARE_MENTION_LN: f64 = 1.0;
/// How many are looked at again: the best at the learned noise, and the best in a quiet one.
const BEST: usize = 2;
const BEST_IN_QUIET: usize = 3;
/// The learned noise chooses the shape where it sees the effect at all, ln.
const SEEN_LN: f64 = 3.0;
/// Repeatable motions of a rotary axis are natural up to this share of the variance of a single reading: every bearing, encoder and gear has
/// some. Not quite half the standard deviation where nothing else is at work; next to a larger effect they are not what is missing.
/// Both shares are tuned on trials of the built-in simulator with empty runs [docs/decisions/0002-thresholds-of-model-comparison.md].
pub const NATURAL_SHARE: f64 = 0.2;
pub const NATURAL_SHARE_WITH_OTHERS: f64 = 0.6;

/// ln odds at which something is claimed come after this: the prior for the number of effects and its own.
pub fn price_ln(scan: &Scan<'_>, group: usize) -> f64 {
    (scan.named.len().max(1) as f64).ln() + scan.named[group].price_ln
}

/// Those worth it, best first; `but` are left out.
pub fn named(scan: &Scan<'_>, view: &Seen, but: &[usize], claim_ln: f64) -> Vec<Scored> {
    first_named(scan, view, but, claim_ln, [BEST, BEST_IN_QUIET])
}

/// The same of so many only, by what they say at the learned noise and in a quiet one.
pub fn first_named(
    scan: &Scan<'_>,
    view: &Seen,
    but: &[usize],
    claim_ln: f64,
    most: [usize; 2],
) -> Vec<Scored> {
    let mut scored = scored_each(scan, view, &worth_it(scan, view, but, claim_ln, most));
    scored.sort_by(|a, b| b.item.ln_odds.total_cmp(&a.item.ln_odds));
    plainest_first(scan, &mut scored);
    scored
}

/// Of those that differ by no more than a bare mention, the one that can do least otherwise comes first: where only the twist of a sag is seen,
/// it is the first harmonic of an encoder.
fn plainest_first(scan: &Scan<'_>, scored: &mut [Scored]) {
    let Some(best) = scored.first().map(|scored| scored.item.ln_odds) else { return };
    let close = scored.iter().take_while(|scored| scored.item.ln_odds > best - BARE_MENTION_LN).count();
    let most_columns = |scored: &Scored| match scored.item.what {
        What::Named(group) => scan.widths[scan.named[group].parts.clone()].iter().max().copied(),
        What::Open(_) => None,
    };
    scored[..close].sort_by_key(most_columns);
}

fn worth_it(scan: &Scan<'_>, view: &View, but: &[usize], claim_ln: f64, most: [usize; 2]) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    let rank = |of: fn(&OnGrid) -> f64, most: usize, chosen: &mut Vec<usize>| {
        let mut order: Vec<usize> = (0..scan.named.len()).filter(|g| !but.contains(g)).collect();
        order.sort_by(|&a, &b| of(&view.named[b]).total_cmp(&of(&view.named[a])));
        for &group in order.iter().take(most) {
            if !chosen.contains(&group) {
                chosen.push(group);
            }
        }
    };
    rank(|score| score.ln_bf, most[0], &mut chosen);
    rank(|score| score.quiet_ln_bf, most[1], &mut chosen);
    chosen.retain(|&group| {
        let score = &view.named[group];
        score.ln_bf.max(score.quiet_ln_bf) > price_ln(scan, group) + claim_ln
    });
    chosen
}

/// Some effects, each with the noise learned with it.
pub fn scored_each(scan: &Scan<'_>, view: &Seen, groups: &[usize]) -> Vec<Scored> {
    view.scored(groups, |view, group| scored(scan, view, group))
}

fn scored(scan: &Scan<'_>, view: &View, group: usize) -> Option<Scored> {
    let named = &scan.named[group];
    let on_grid = &view.named[group];
    let part = if on_grid.ln_bf > SEEN_LN { on_grid.part } else { on_grid.quiet_part };
    let noise = view.relearned(scan, &scan.part(part))?;
    let first = scan.widths[..named.parts.start].iter().sum::<usize>();
    let widths = &scan.widths[named.parts.clone()];
    let own = scan.columns.columns(first, widths.iter().sum()).into_owned();
    let scores = evidence_of_each(&noise.alone, &own, widths);
    let ln: Vec<f64> = scores.iter().map(|score| score.ln_bf).collect();
    let best = (0..ln.len()).max_by(|&a, &b| ln[a].total_cmp(&ln[b]))?;
    let averaged = (named.averaged(&ln) + noise.offset_ln).max(on_grid.ln_bf);
    let (shape, columns) = best_shape(scan, &noise.alone, group, best);
    let block = turned(&columns);
    let at_best = evidence_relearned(&noise, &block);
    let ln_bf = averaged.max(at_best.ln_bf - shape_price_ln(named.tries, &shape));
    let least = natural_share(scan, view);
    let noticeable = !named.natural || view.share(scan, &noise, &block) > least;
    let item = Item { what: What::Named(group), shape, columns, ln_odds: ln_bf - price_ln(scan, group) };
    Some(Scored { item, ln_bf, fit_ln: at_best.fit_ln, noise: Arc::new(noise), noticeable })
}

/// Share of the white variance up to which a repeatable motion is natural.
pub fn natural_share(scan: &Scan<'_>, view: &View) -> f64 {
    let of_single = if view.chosen.ncols() == 0 { NATURAL_SHARE } else { NATURAL_SHARE_WITH_OTHERS };
    of_single * scan.remainder.kernels.single.powi(2)
}

/// Shape numbers moved from the grid to where the evidence is best.
fn best_shape(
    scan: &Scan<'_>,
    alone: &crate::noise::learned::sigma::Projected,
    group: usize,
    best: usize,
) -> (Vec<f64>, DMatrix<f64>) {
    let named = &scan.named[group];
    let shape = named.shapes.grid[best].clone();
    let columns = |shape: &[f64]| scan.finite_columns_of(&named.instance, shape);
    let first = columns(&shape).unwrap_or_else(|| DMatrix::zeros(scan.remainder.y.len(), 0));
    if !named.shapes.continuous || named.shapes.grid.len() < 2 || first.ncols() == 0 {
        return (shape, first);
    }
    let gain_ln = |columns: &DMatrix<f64>| evidence_of(alone, &turned(columns)).ln_bf;
    let within = stretches(&named.shapes.grid, &shape, None);
    let start = Shaped { gain_ln: gain_ln(&first), shape, columns: first };
    let Shaped { shape, columns, .. } = refined(start, &within, columns, gain_ln);
    (shape, columns)
}
