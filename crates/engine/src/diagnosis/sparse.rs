//! What a name says next to an expression, which may leave out components: here the name may too (docs/design/statistics.md §4.3).

use crate::diagnosis::named::price_ln;
use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{Scored, shape_price_ln};
use crate::diagnosis::view::Relearned;
use crate::evidence::{BestSet, best_set, evidence_of, parallel, turned};
use crate::noise::learned::sigma::Projected;
use nalgebra::DMatrix;

/// ln odds of an addition where some of its columns may be absent; at least those of all at its own noise. `other`: a noise learned with what
/// competes, where that explains more. The best set may have another shape than all columns together: one time constant where these have two.
pub fn sparse_ln_odds(scan: &Scan<'_>, scored: &Scored, other: Option<&Relearned>) -> f64 {
    let Some(group) = scored.item.what.group() else { return scored.item.ln_odds };
    let at = |noise: &Relearned| {
        let (set, shape) = best_set_and_shape(scan, scored, group, &noise.alone)?;
        let shape_price_ln = shape_price_ln(scan.named[group].tries, &shape);
        Some(set.ln_bf + noise.offset_ln - shape_price_ln - price_ln(scan, group))
    };
    other.into_iter().chain([&*scored.noise]).filter_map(at).fold(scored.item.ln_odds, f64::max)
}

/// The best set of columns of a named effect, at its best shape.
fn best_set_and_shape(
    scan: &Scan<'_>,
    scored: &Scored,
    group: usize,
    here: &Projected,
) -> Option<(BestSet, Vec<f64>)> {
    let named = &scan.named[group];
    let grid = &named.shapes.grid;
    let first = (best_set(here, &scored.item.columns)?, scored.item.shape.clone());
    if !named.shapes.continuous || grid.len() < 2 {
        return Some(first);
    }
    let columns = |shape: &[f64]| scan.finite_columns_of(&named.instance, shape);
    let at = |i: usize| Some((best_set(here, &columns(&grid[i])?)?, grid[i].clone()));
    let on_grid = parallel(grid.len(), at).into_iter().flatten();
    let (set, shape) = on_grid.chain([first]).max_by(|a, b| a.0.ln_bf.total_cmp(&b.0.ln_bf))?;
    let of_set = |shape: &[f64]| Some(columns(shape)?.select_columns(&set.columns));
    let gain_ln = |columns: &DMatrix<f64>| evidence_of(here, &turned(columns)).ln_bf - set.price_ln;
    let within = stretches(grid, &shape, None);
    let start = Shaped { columns: of_set(&shape)?, gain_ln: set.ln_bf, shape };
    let Shaped { shape, gain_ln, .. } = refined(start, &within, of_set, gain_ln);
    Some((BestSet { ln_bf: gain_ln, ..set }, shape))
}
