//! What is confounded with an effect in these data: names with nearly its evidence, and names that imitate what was fitted with it.

use crate::diagnosis::named::named;
use crate::diagnosis::scan::{Named, Scan};
use crate::diagnosis::scored::Scored;
use crate::diagnosis::search::Found;
use crate::diagnosis::view::{Item, View, What, columns_of, fitted};
use crate::evidence::{joined, turned};
use crate::noise::learned::Real;
use nalgebra::{DMatrix, DVector};

/// Rivals within this ln of the Bayes factor are confused, and fits as close are as good: odds below 20 to 1 are no strong evidence
/// [Kass 1995].
pub const CONFUSED_LN: f64 = 3.0;
/// Share of the fitted signal, in the metric of the learned noise, at which a block is another name for the same readings.
const IMITATES: f64 = 0.95;
/// Directions of a block below this share of its largest eigenvalue are not seen.
const SEEN: f64 = 1e-3;

/// Groups that are confused with one of the items found, most likely first.
pub fn confused_with(scan: &Scan<'_>, found: &Found, item: &Item, claim_ln: f64) -> Vec<usize> {
    let Some(group) = item.what.group() else { return Vec::new() };
    let kept = |g: &usize| found.items.iter().any(|other| other.what == What::Named(*g));
    let others = found.items.iter().filter(|other| other.what != item.what);
    let chosen = joined(&columns_of(others, scan.remainder.y.len()), &found.further);
    let alone = chosen.ncols() == 0;
    let view = match alone {
        true => Some(found.before.clone()),
        false => found.views.of(scan, chosen, &found.last.null.here.sigma),
    };
    let Some(view) = view else { return Vec::new() };
    let scored: Vec<Scored> = if alone { found.first.clone() } else { named(scan, &view, &[], claim_ln) };
    // What is worth a claim next to all that was found is there too, and stands for nothing of it.
    let is_another = |g: &usize| found.last.named[*g].ln_bf > claim_ln;
    let of_group = |g: usize| move |scored: &&Scored| scored.item.what == What::Named(g);
    let own = scored.iter().find(of_group(group)).map_or(f64::INFINITY, |scored| scored.ln_bf);
    let mut confused: Vec<usize> = scored
        .iter()
        .filter(|scored| scored.ln_bf > own - CONFUSED_LN && scored.ln_bf > 0.0)
        .filter_map(|scored| scored.item.what.group())
        .filter(|g| !is_another(g))
        .collect();
    confused.extend(imitators(scan, &view, item));
    let mut seen = vec![group];
    confused.retain(|g| {
        let new = !seen.contains(g) && !kept(g);
        seen.push(*g);
        new
    });
    confused
}

/// Named effects of which one shape imitates what was fitted with an item.
fn imitators(scan: &Scan<'_>, view: &View, item: &Item) -> Vec<usize> {
    let here = &view.null.here;
    let signal = fitted(here, &turned(&item.columns)).cast::<Real>();
    let on_basis = (here.weighted.tr_mul(&signal)).cast::<f64>();
    let seen: DVector<Real> =
        &here.sigma.inverse * &signal - &here.weighted * (&here.cofactor * on_basis).cast::<Real>();
    let square: f64 = signal.iter().zip(seen.iter()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    let imitates = |gram: &DMatrix<f64>, on_signal: DVector<f64>| {
        if gram.is_empty() {
            return false;
        }
        let eigen = ((gram + gram.transpose()) * 0.5).symmetric_eigen();
        let along = eigen.eigenvectors.tr_mul(&on_signal);
        let least = SEEN * eigen.eigenvalues.amax();
        let pairs = eigen.eigenvalues.iter().zip(along.iter()).filter(|(lambda, _)| **lambda > least);
        pairs.map(|(lambda, z)| z * z / lambda).sum::<f64>() > IMITATES * square
    };
    let products = scan.columns.tr_mul(&seen).cast::<f64>();
    let mut first = 0;
    let of_parts: Vec<bool> = view
        .grams
        .iter()
        .map(|gram| {
            let on_signal = products.rows(first, gram.ncols()).into_owned();
            first += gram.ncols();
            imitates(gram, on_signal)
        })
        .collect();
    // No fit tried these: on these poses they are another shape, or another effect.
    let as_alias = |named: &Named| {
        named.shapes.aliased.iter().any(|shape| {
            let block = turned(&scan.columns_of(&named.instance, shape)).cast::<Real>();
            let gram = here.grams(&block, &[block.ncols()]).remove(0);
            imitates(&gram, block.tr_mul(&seen).cast::<f64>())
        })
    };
    let is_imitator = |g: &usize| {
        let named = &scan.named[*g];
        named.parts.clone().any(|part| of_parts[part]) || as_alias(named)
    };
    (0..scan.named.len()).filter(is_imitator).collect()
}
