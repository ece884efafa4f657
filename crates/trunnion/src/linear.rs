//! A diagnosed fit next to the fit of every change of one effect: what each takes off the residual, to first order.

use crate::{Diagnosed, Error, Experiment, Fit, FormulaText, Model};
use nalgebra::{DMatrix, DVector};
use std::error::Error as _;
use trunnion_core::convert::um_from_mm;
use trunnion_effects::{Instance, ModelEffect};
use trunnion_results as results;
use trunnion_results::number::{rounded, um};
use trunnion_results::sentences::effect_name;

/// Most candidates that are fitted for what-if: those that a page lists first.
const MOST_CANDIDATES: usize = 5;
/// Decimals of µm: a hundredth of what a screen shows.
const DECIMALS: i32 = 4;

impl Diagnosed {
    /// Points and solutions for what-if: `trunnion-linear/2`.
    ///
    /// # Errors
    /// When the fit of a change fails.
    pub fn linear(&self) -> Result<results::Linear, Error> {
        let fit = self.fit();
        let answer = self.results();
        let mut fits = vec![(String::new(), false, fit.clone())];
        for (effect, _) in fit.model().ladder().added() {
            let smaller: Model = without(fit.model(), effect);
            fits.push((effect.into(), true, fit.experiment().fit(&smaller)?));
        }
        let named = answer.candidates.iter().map(|candidate| candidate.effect.clone());
        let offered = named.take(MOST_CANDIDATES).chain(answer.best());
        let mut tried: Vec<String> = Vec::new();
        for effect in offered {
            if !tried.contains(&effect) {
                fits.push((effect.clone(), false, self.add(&effect)?.fit().clone()));
                tried.push(effect);
            }
        }
        let experiment = fit.experiment().points();
        let shown = results::Residuals::new(experiment, &fit.identification().predicted_mm, &[]);
        let every = shown.every.max(1);
        let rows: Vec<usize> =
            (0..experiment.points.len()).step_by(every).flat_map(|i| experiment.rows_of(i)).collect();
        let mut placed = Placed::default();
        let of_model_mm = placed.motion_mm(fit);
        let of_rows = |all_mm: &DVector<f64>| {
            rows.iter().map(|&row| rounded(um_from_mm(all_mm[row]), DECIMALS)).collect()
        };
        let solutions = fits.into_iter().map(|(changed, is_without, of_set)| {
            let found = of_set.identification();
            let rms_um = um_from_mm(found.rms_mm);
            results::LinearSolution {
                title: if changed.is_empty() { "The model".into() } else { effect_name(&changed) },
                change_um: if changed.is_empty() {
                    Vec::new()
                } else {
                    of_rows(&(placed.motion_mm(&of_set) - &of_model_mm))
                },
                changed,
                without: is_without,
                rms_um,
                rms: um(rms_um),
                excluded: found.outliers.iter().map(|outlier| outlier.point).collect(),
            }
        });
        Ok(results::Linear {
            solutions: solutions.collect(),
            format: results::LinearFormat::V2,
            residual_um: of_rows(&fit.identification().residual_mm),
            points: shown.points.iter().map(results::LinearPoint::from).collect(),
            axes: shown.axes,
            setups: shown.setups,
        })
    }
}

impl Experiment {
    /// An expression as far as it is typed: could the model hold it?
    pub fn check_formula(&self, text: &FormulaText) -> results::FormulaChecked {
        let entry = ModelEffect {
            id: "formula:typed".into(),
            site: text.site.clone(),
            component: text.component.clone(),
            expression: text.expression.clone(),
            grid: text.grid.clone(),
            ..ModelEffect::default()
        };
        let invalid =
            |problem: String| results::FormulaChecked { problem, ..results::FormulaChecked::default() };
        let instance = match Instance::from_model_effect(&entry, self.machine()) {
            Ok(instance) => instance,
            // The cause says what; that it is a formula of this name is known.
            Err(problem) => {
                return invalid(problem.source().map_or_else(|| problem.to_string(), ToString::to_string));
            }
        };
        let scene = &self.points().scene;
        if let Some(why) = instance.out_of_reach(scene) {
            return invalid(why);
        }
        results::FormulaChecked {
            valid: true,
            parameters: instance.parameters(scene).iter().map(|p| p.name.clone()).collect(),
            shapes: instance.shapes(scene).names,
            ..results::FormulaChecked::default()
        }
    }
}

fn without(model: &Model, effect: &str) -> Model {
    let mut smaller = model.entries().clone();
    smaller.effects.retain(|entry| entry.id != effect && entry.added_as() != effect);
    smaller.into()
}

/// Columns of the effects that were met so far, mm per unit.
#[derive(Default)]
struct Placed {
    known: Vec<(String, Vec<f64>, DMatrix<f64>)>,
}

impl Placed {
    /// What the effects of a fit do to every reading, to first order, mm.
    fn motion_mm(&mut self, fit: &Fit) -> DVector<f64> {
        let (found, experiment) = (fit.identification(), fit.experiment().points());
        let mut motion_mm = DVector::zeros(experiment.rows());
        for (entry, effect) in fit.model().entries().effects.iter().zip(&found.effects) {
            let is_known =
                |(id, shape, _): &(String, Vec<f64>, _)| *id == effect.id && *shape == effect.shape;
            let place = self.known.iter().position(is_known).unwrap_or_else(|| {
                // The fit placed the same entry: it can be made.
                let columns = Instance::from_model_effect(entry, fit.experiment().machine()).map_or_else(
                    |_| DMatrix::zeros(experiment.rows(), 0),
                    |instance| experiment.columns(&instance, &effect.shape),
                );
                self.known.push((effect.id.clone(), effect.shape.clone(), columns));
                self.known.len() - 1
            });
            let of_effect = found.parameters.iter().zip(found.solution.iter());
            let values = of_effect.filter(|(p, _)| p.effect == effect.id).map(|(_, value)| value);
            for (column, value) in self.known[place].2.column_iter().zip(values) {
                motion_mm.axpy(*value, &column, 1.0);
            }
        }
        motion_mm
    }
}
