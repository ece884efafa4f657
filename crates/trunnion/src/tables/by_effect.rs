//! What each effect of a model makes of every reading.
//!
//! Effects that are confounded in these runs share a part: along a direction that is not observable one takes what
//! another gives, and only their sum is known. Parts are of first order; with that of the positions alone they add up to the prediction
//! but for the squares of the errors.

use crate::Fit;
use nalgebra::{DVector, Vector3};
use trunnion_core::convert::um_from_mm;
use trunnion_effects::Instance;
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// The part that the recorded positions make without any effect.
const POSITIONS: &str = "positions";

/// The table: one line for a point and part of the model.
pub fn by_effect_csv(fit: &Fit) -> String {
    let points = fit.experiment().points();
    let residuals = fit.residuals();
    let listed = |part: &DVector<f64>| -> Vec<Vec<f64>> {
        let indices = (0..points.points.len()).step_by(residuals.every.max(1));
        indices.map(|i| points.rows_of(i).map(|row| um_from_mm(part[row])).collect()).collect()
    };
    let mut parts = vec![(POSITIONS.to_owned(), listed(&of_positions(fit)))];
    parts.extend(of_effects(fit).iter().map(|(effects, part)| (effects.clone(), listed(part))));
    trunnion_report::by_effect_csv(&residuals, &parts)
}

fn of_positions(fit: &Fit) -> DVector<f64> {
    let points = fit.experiment().points();
    let mut nominal_mm = DVector::zeros(points.rows());
    for (i, point) in points.points.iter().enumerate() {
        let setup = &points.setups[point.state.setup];
        let nominal: Vector3<f64> = predict(points.machine(), setup, &point.state, &Errors::default());
        for (k, row) in points.rows_of(i).enumerate() {
            nominal_mm[row] = nominal[k];
        }
    }
    nominal_mm
}

/// Columns times solution of each effect, effects that are confounded together, mm.
fn of_effects(fit: &Fit) -> Vec<(String, DVector<f64>)> {
    let (points, found) = (fit.experiment().points(), fit.identification());
    let entries = &fit.model().entries().effects;
    let together = parts_of(fit);
    let mut parts: Vec<(String, DVector<f64>)> =
        together.iter().map(|_| (String::new(), DVector::zeros(points.rows()))).collect();
    let mut first = 0;
    for (k, entry) in entries.iter().enumerate() {
        let Ok(instance) = Instance::from_model_effect(entry, points.machine()) else { continue };
        let columns = points.columns(&instance, &found.effects[k].shape);
        let solution = found.solution.rows(first, columns.ncols());
        first += columns.ncols();
        let Some((name, part)) = together.iter().position(|part| part.contains(&k)).map(|at| &mut parts[at])
        else {
            continue;
        };
        *name = if name.is_empty() { entry.id.clone() } else { format!("{name} + {}", entry.id) };
        *part += columns * solution;
    }
    parts
}

/// Indices of the effects of each part, in the order of the model.
fn parts_of(fit: &Fit) -> Vec<Vec<usize>> {
    let found = fit.identification();
    let effect_of = |parameter: usize| {
        let effect = &found.parameters[parameter].effect;
        found.effects.iter().position(|fitted| fitted.id == *effect)
    };
    let mut parts: Vec<Vec<usize>> = (0..found.effects.len()).map(|k| vec![k]).collect();
    for direction in &found.unobservable {
        let confounded: Vec<usize> =
            direction.inside.iter().filter_map(|(parameter, _)| effect_of(*parameter)).collect();
        let (mut joined, apart): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|part| part.iter().any(|effect| confounded.contains(effect)));
        parts = apart;
        let mut joined = joined.drain(..).flatten().collect::<Vec<_>>();
        joined.sort_unstable();
        parts.push(joined);
    }
    parts.retain(|part| !part.is_empty());
    parts.sort();
    parts
}
