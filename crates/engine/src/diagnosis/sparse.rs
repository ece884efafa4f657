//! What a name says next to an expression, which may leave out components: here the name may too (docs/design/statistics.md §4.3).

use crate::diagnosis::named::price_ln;
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{Scored, shape_price_ln};
use crate::evidence::of_some_ln;

/// ln odds of an addition where some of its columns may be absent, at its shape and the noise learned with it; at least those of all columns.
pub fn sparse_ln_odds(scan: &Scan<'_>, scored: &Scored) -> f64 {
    let Scored { item, noise, .. } = scored;
    let sparse_ln = item.what.group().and_then(|group| {
        let price_ln = shape_price_ln(scan.named[group].tries, &item.shape) + price_ln(scan, group);
        Some(of_some_ln(&noise.alone, &item.columns)? + noise.offset_ln - price_ln)
    });
    sparse_ln.map_or(item.ln_odds, |ln| ln.max(item.ln_odds))
}
