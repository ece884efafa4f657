//! Is what was named of one size always and everywhere? (docs/design/statistics.md §4.2)
//!
//! With f the readings fitted with an effect, columns f·t and f·cos q, f·sin q of every axis that turns (f·q of every linear axis where none
//! does) are weighed next to it. An effect that changes with them is more than its name says: a run-out that grows while the machine
//! warms, a mesh that is deeper on one side of the turn.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::search::Found;
use crate::diagnosis::view::{Item, columns_of, evidence_relearned, fitted};
use crate::evidence::{joined, orthonormal, turned};
use crate::noise::learned::Real;
use crate::noise::learned::sigma::Projected;
use crate::noise::machine_noise::modulated;
use crate::problem::sequence::clocks_and_times;
use nalgebra::{DMatrix, DVector};

/// True where no effect that was found changes with time or place by more than chance and noise may do.
pub fn is_constant(scan: &Scan<'_>, found: &Found, claim_ln: f64) -> bool {
    let signals: Vec<DVector<f64>> =
        found.items.iter().filter_map(|item| signal(scan, found, item)).collect();
    let changes = changes(scan);
    if signals.is_empty() {
        return true;
    }
    let price = ((signals.len() * changes.len()).max(1) as f64).ln() + claim_ln;
    let blocks = signals.iter().flat_map(|signal| changes.iter().map(|change| block(scan, signal, change)));
    let best = blocks
        .filter(|block| block.ncols() > 0)
        .map(|block| (found.last.ln_bf(&block), block))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, block)) = best.filter(|(ln_bf, _)| *ln_bf > price) else { return true };
    let noise = found.last.relearned(scan, &block);
    noise.is_none_or(|noise| evidence_relearned(&noise, &block).ln_bf <= price)
}

/// What an item explains with the others in the model, weighted.
fn signal(scan: &Scan<'_>, found: &Found, item: &Item) -> Option<DVector<f64>> {
    let others = found.items.iter().filter(|other| other.what != item.what);
    let others = joined(&columns_of(others, scan.remainder.y.len()), &found.further);
    let basis = orthonormal(&joined(&scan.remainder.base, &others)).cast::<Real>();
    let alone = Projected::new(found.last.null.here.sigma.clone(), &scan.remainder.y, &basis)?;
    Some(fitted(&alone, &turned(&item.columns)))
}

/// Turned columns of a signal that changes.
fn block(scan: &Scan<'_>, signal: &DVector<f64>, change: &[Vec<f64>]) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = change
        .iter()
        .map(|factor| modulated(&scan.remainder.rows.points, signal, |point| factor[point]))
        .collect();
    turned(&DMatrix::from_columns(&columns))
}

/// Factors of every change, one list of values for each: time, and the place on every axis that moves.
fn changes(scan: &Scan<'_>) -> Vec<Vec<Vec<f64>>> {
    let experiment = &scan.remainder.rows.points;
    let points = 0..experiment.points.len();
    let times = clocks_and_times(experiment).into_iter().map(|(_, time)| time).collect();
    let mut changes = vec![vec![centred(times)]];
    let scene = &experiment.scene;
    let turning = experiment.machine().rotary_joints().into_iter().any(|joint| scene.moves(joint));
    for axis in experiment.machine().axes() {
        let place = |i: usize| experiment.points[i].state.position[axis.letter];
        if !scene.moves(axis.letter) || axis.letter.is_rotary() != turning {
            continue;
        }
        changes.push(match turning {
            true => [f64::cos, f64::sin]
                .map(|wave| centred(points.clone().map(|i| wave(place(i))).collect()))
                .into(),
            false => vec![centred(points.clone().map(place).collect())],
        });
    }
    changes
}

/// Off the mean: what does not change is the effect itself.
fn centred(mut values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    values
}
