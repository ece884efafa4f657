//! A diagnosed fit as a matrix product: columns of its effects and candidates, and the fit of every change of one effect.

use crate::{Diagnosed, Error, Experiment, Fit, FormulaText, Model};
use std::error::Error as _;
use trunnion_core::convert::um_from_mm;
use trunnion_effects::{Instance, ModelEffect};
use trunnion_results as results;
use trunnion_results::number::um;
use trunnion_results::sentences::effect_name;

/// Most candidates that are fitted for what-if: those that a page lists first.
const MOST_CANDIDATES: usize = 5;
/// Digits of a column: a thousandth of what a screen shows of the largest motion.
const DIGITS: f64 = 6.0;

impl Diagnosed {
    /// Points, columns and solutions for what-if: `trunnion-linear/1`.
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
        let residual_mm = &fit.identification().residual_mm;
        let mut blocks: Vec<Block> = Vec::new();
        let placed: Vec<Vec<(usize, f64)>> =
            fits.iter().map(|(_, _, fit)| place(fit, &rows, &mut blocks)).collect();
        let width = blocks.iter().map(|block| block.columns.len()).sum();
        let solutions = fits.into_iter().zip(placed).map(|((changed, is_without, fit), placed)| {
            let mut values = vec![0.0; width];
            placed.into_iter().for_each(|(column, value)| values[column] = value);
            let rms_um = um_from_mm(fit.identification().rms_mm);
            results::LinearSolution {
                title: if changed.is_empty() { "The model".into() } else { effect_name(&changed) },
                changed,
                without: is_without,
                values,
                rms_um,
                rms: um(rms_um),
                excluded: fit.identification().outliers.iter().map(|outlier| outlier.point).collect(),
            }
        });
        Ok(results::Linear {
            solutions: solutions.collect(),
            format: results::LinearFormat::V1,
            residual_um: rows.iter().map(|&row| short(um_from_mm(residual_mm[row]))).collect(),
            points: shown.points.iter().map(results::LinearPoint::from).collect(),
            axes: shown.axes,
            setups: shown.setups,
            columns: blocks.into_iter().flat_map(|block| block.columns).collect(),
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
    smaller.effects.retain(|entry| entry.id != effect);
    smaller.into()
}

/// Columns of one effect with one shape.
struct Block {
    effect: String,
    shape: Vec<f64>,
    first: usize,
    columns: Vec<results::LinearColumn>,
}

/// Puts the effects of a fit among the blocks; gives each of its values with the index of its column.
fn place(fit: &Fit, rows: &[usize], blocks: &mut Vec<Block>) -> Vec<(usize, f64)> {
    let (found, experiment) = (fit.identification(), fit.experiment().points());
    let mut values = Vec::new();
    for (entry, effect) in fit.model().entries().effects.iter().zip(&found.effects) {
        let parameters = found.parameters.iter().enumerate().filter(|(_, p)| p.effect == effect.id);
        let known = blocks.iter().position(|block| block.effect == effect.id && block.shape == effect.shape);
        let block = known.unwrap_or_else(|| {
            let first = blocks.last().map_or(0, |last| last.first + last.columns.len());
            let column = |mm: nalgebra::DVectorView<'_, f64>,
                          (_, p): (usize, &trunnion_engine::FittedParameter)| {
                results::LinearColumn {
                    effect: effect.id.clone(),
                    parameter: p.name.clone(),
                    unit: p.unit.symbol.into(),
                    values: rows.iter().map(|&row| short(um_from_mm(mm[row]) / p.unit.per_inside)).collect(),
                }
            };
            // The fit placed the same entry: it can be made.
            let columns = Instance::from_model_effect(entry, fit.experiment().machine())
                .map(|instance| experiment.columns(&instance, &effect.shape));
            let columns = columns.map_or_else(
                |_| Vec::new(),
                |mm| mm.column_iter().zip(parameters.clone()).map(|(mm, p)| column(mm, p)).collect(),
            );
            blocks.push(Block { effect: effect.id.clone(), shape: effect.shape.clone(), first, columns });
            blocks.len() - 1
        });
        let first = blocks[block].first;
        values.extend(
            parameters.enumerate().map(|(k, (j, p))| (first + k, found.solution[j] * p.unit.per_inside)),
        );
    }
    values
}

/// Rounded to `DIGITS` digits.
fn short(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let scale = 10_f64.powf(DIGITS - 1.0 - value.abs().log10().floor());
    (value * scale).round() / scale
}
