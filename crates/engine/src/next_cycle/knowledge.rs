//! What the present data say of the rivals: their best shapes, values with precision, and which noise explains the rest.

use super::design::CycleDesign;
use super::information::Information;
use super::rivals::Rivals;
use super::separation::Known;
use crate::problem::credible::typical_size;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_effects::Scene;

/// What the present data say of the rivals.
pub(super) struct Knowledge {
    /// Best shape of each rival.
    pub shapes: Vec<Vec<f64>>,
    /// For each noise model how much worse than the best it explains the present data (ln), and its variance.
    pub noises: Vec<(f64, f64)>,
    /// For each rival and noise model: parameter names, values and precision; `None` where the data do not show it.
    fitted: Vec<Option<Fitted>>,
}

struct Fitted {
    names: Vec<String>,
    /// Values and precision for each noise model.
    by_noise: Vec<(DVector<f64>, DMatrix<f64>)>,
}

impl CycleDesign<'_> {
    /// Shapes, values, noise from the present data.
    pub(super) fn knowledge(&self) -> Knowledge {
        let experiment = &self.present.experiment;
        let shaped = self.shaped(&experiment.scene, None);
        let model = self.present.model_columns(experiment);
        let information =
            Information::new(experiment, &model, &shaped.parts, Some(&self.present.residual_mm));
        let best_of = |rival: &Range<usize>| {
            let gain =
                |p: usize| information.views.iter().map(|v| v.explained(&information.parts[p])).sum::<f64>();
            rival.clone().max_by(|&a, &b| gain(a).total_cmp(&gain(b)))
        };
        let best: Vec<Option<usize>> = shaped.of_rival.iter().map(best_of).collect();
        let shapes = best.iter().enumerate().map(|(i, part)| match part {
            // A rival the present scene cannot have takes its first shape.
            None => self.entries[i].shape.clone(),
            Some(p) => shaped.parts[*p].shape.clone(),
        });
        let mut noises: Vec<(f64, f64)> = information
            .views
            .iter()
            .map(|view| {
                let gain =
                    best.iter().flatten().map(|&p| view.explained(&information.parts[p])).fold(0.0, f64::max);
                let left = (view.readings_squared() - gain).max(1e-18);
                let freedom = (information.rows as f64 - view.rank as f64 - 4.0).max(1.0);
                (-0.5 * view.log_det - 0.5 * freedom * left.ln(), left / freedom)
            })
            .collect();
        let top = noises.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
        for (ln, _) in &mut noises {
            *ln = top - *ln;
        }
        let fitted = best.iter().enumerate().map(|(i, part)| {
            let range = &information.parts[(*part)?];
            let by_noise: Vec<_> = information
                .views
                .iter()
                .zip(&noises)
                .map(|(view, (_, variance))| (view.values(range), view.between(range, range) / *variance))
                .collect();
            let shown = by_noise.iter().all(|(values, precision)| Known::is_significant(values, precision));
            let parameters = self.instances[i].parameters(&experiment.scene);
            let names = parameters.into_iter().map(|parameter| parameter.name).collect();
            shown.then_some(Fitted { names, by_noise })
        });
        let fitted = match self.rivals {
            Rivals::Separate(_) => fitted.collect(),
            // What cannot be seen has no values worth keeping.
            Rivals::Reveal(_) => self.entries.iter().map(|_| None).collect(),
        };
        Knowledge { shapes: shapes.collect(), noises, fitted }
    }

    /// What is known of a rival's parameters, in the order the scene gives them.
    pub(super) fn known(&self, rival: usize, noise: usize, knowledge: &Knowledge, scene: &Scene) -> Known {
        let parameters = self.instances[rival].parameters(scene);
        let Some(fitted) = &knowledge.fitted[rival] else {
            let sizes = parameters.iter().map(|p| typical_size(p.unit));
            return Known::Typical(DVector::from_iterator(parameters.len(), sizes));
        };
        let (values, precision) = &fitted.by_noise[noise];
        let from: Vec<Option<usize>> =
            parameters.iter().map(|p| fitted.names.iter().position(|name| *name == p.name)).collect();
        let n = parameters.len();
        Known::Fitted(
            DVector::from_fn(n, |i, _| from[i].map_or(0.0, |k| values[k])),
            DMatrix::from_fn(n, n, |i, j| match (from[i], from[j]) {
                (Some(k), Some(l)) => precision[(k, l)],
                _ => 0.0,
            }),
        )
    }
}
