//! A diagnosed fit next to the fit of every change of one effect: what each takes off the residual, to first order.

use crate::{Diagnosed, Error, Experiment, Fit, FormulaText, Model};
use nalgebra::{DMatrix, DVector};
use std::error::Error as _;
use trunnion_core::convert::um_from_mm;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, ModelEffect};
use trunnion_results as results;
use trunnion_results::number::{rounded, um};
use trunnion_results::sentences::{effect_name, formula_id};

/// Most candidates that are fitted for what-if: those that a page lists first.
const MOST_CANDIDATES: usize = 5;
/// Id of an expression that was typed.
const TYPED: &str = "formula:typed";
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
        let mut fits = Vec::new();
        for effect in switched(fit.model()) {
            let smaller: Model = without(fit.model(), effect);
            fits.push((effect.into(), true, fit.experiment().fit(&smaller)?));
        }
        let named = answer.candidates.iter().map(|candidate| candidate.effect.clone());
        let proposed = answer.formula.as_ref().map(formula_id);
        let offered = named.take(MOST_CANDIDATES).chain(proposed);
        let mut tried: Vec<String> = Vec::new();
        for effect in offered {
            if !tried.contains(&effect) {
                fits.push((effect.clone(), false, self.add(&effect)?.fit().clone()));
                tried.push(effect);
            }
        }
        Ok(of_changes(fit, fits))
    }

    /// The same of the model and an expression that was typed: two solutions, the second with it.
    ///
    /// # Errors
    /// An expression that the model cannot hold, or whose fit fails.
    pub fn linear_with(&self, text: &FormulaText) -> Result<results::Linear, Error> {
        let with = self.fit().add_as(TYPED, text)?.fit().clone();
        let mut answer = of_changes(self.fit(), vec![(TYPED.into(), false, with)]);
        let of = |text: &Option<String>| text.clone().unwrap_or_default();
        if let Some(typed) = answer.solutions.last_mut() {
            typed.title = format!("{} {}: {}", of(&text.site), of(&text.component), of(&text.expression));
        }
        Ok(answer)
    }
}

/// The fits of a model and of each change of it: what changed, and whether it is left out.
fn of_changes(fit: &Fit, changes: Vec<(String, bool, Fit)>) -> results::Linear {
    let experiment = fit.experiment().points();
    let shown = results::Residuals::new(experiment, &fit.identification().predicted_mm, &[]);
    let every = shown.every.max(1);
    let rows: Vec<usize> =
        (0..experiment.points.len()).step_by(every).flat_map(|i| experiment.rows_of(i)).collect();
    let mut placed = Placed::default();
    let of_model_mm = placed.motion_mm(fit);
    let of_rows =
        |all_mm: &DVector<f64>| rows.iter().map(|&row| rounded(um_from_mm(all_mm[row]), DECIMALS)).collect();
    let model = (String::new(), false, fit.clone());
    let solutions = std::iter::once(model).chain(changes).map(|(changed, is_without, of_set)| {
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
    results::Linear {
        solutions: solutions.collect(),
        format: results::LinearFormat::V2,
        residual_um: of_rows(&fit.identification().residual_mm),
        points: shown.points.iter().map(results::LinearPoint::from).collect(),
        axes: shown.axes,
        setups: shown.setups,
    }
}

impl Experiment {
    /// An expression as far as it is typed: could the model hold it?
    pub fn check_formula(&self, text: &FormulaText) -> results::FormulaChecked {
        let entry = ModelEffect {
            id: TYPED.into(),
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

/// What can be switched off: each act of adding by its first entry, and each entry that a person wrote. Those of every model stay.
fn switched(model: &Model) -> Vec<&str> {
    let entries = &model.entries().effects;
    let came_with_another =
        |entry: &ModelEffect| entry.added_as() != entry.id && model.effects().contains(&entry.added_as());
    let added = entries.iter().filter(|entry| !BASE.contains(&entry.id.as_str()));
    added.filter(|entry| !came_with_another(entry)).map(|entry| entry.id.as_str()).collect()
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
