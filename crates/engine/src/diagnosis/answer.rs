//! From scans to the answer: candidates in order, what each would do, what it could be mistaken for, the verdict.

use crate::diagnosis::contest::named_item;
use crate::diagnosis::families::Number;
use crate::diagnosis::problem::Problem;
use crate::diagnosis::search::{Item, View, What, columns_of, search};
use crate::diagnosis::verdict::{
    Candidate, CandidateParameter, Diagnosis, FormulaProposal, NextCycle, ResidualSummary, ShapeNumber,
    Verdict,
};
use crate::diagnosis::{Options, words};
use crate::evidence::Score;
use nalgebra::DMatrix;
use std::f64::consts::LN_10;
use trunnion_effects::{Formula, Model, ModelEffect, Unit};

/// Rivals within this ln of the posterior odds are confused (a factor of 20).
const CONFUSED_LN: f64 = 3.0;
/// Columns whose smallest canonical correlation exceeds this coincide in this cycle.
const ALIAS: f64 = 0.999;
/// A named effect that explains at least this share leads, although a part remains.
const MOSTLY: f64 = 0.8;

/// Answers for the model of `problem`.
pub fn answer(problem: &Problem<'_>, model: &Model, options: &Options) -> Diagnosis {
    let first = View::of(problem, DMatrix::zeros(0, problem.experiment.rows()));
    let rms_mm = first.fit.rms_mm;
    let (found, complete) = search(problem, &first, options.claim_ln, options.look_ahead);
    let noise_mm = problem.fit(&columns_of(found.iter(), problem.experiment.rows())).rms_mm.min(rms_mm);
    let context = Context { problem, options, first: &first, found: &found, complete, rms_mm, noise_mm };

    let candidates = context.candidates();
    let formula = context.formula();
    let verdict = match (candidates.is_empty(), context.formula_leads(&candidates)) {
        (_, true) => Verdict::UnnamedStructure,
        (false, false) => Verdict::MissingEffect,
        (true, false) => Verdict::NoiseFloor,
    };
    let next_cycle = candidates
        .first()
        .filter(|candidate| !candidate.separate_by.is_empty())
        .map(|candidate| NextCycle::advice(candidate.separate_by.clone()));
    Diagnosis {
        model: model.effects.iter().map(|effect| effect.id.clone()).collect(),
        residual: ResidualSummary {
            rms_um: rms_mm * 1e3,
            noise_um: noise_mm * 1e3,
            unexplained_fraction: 1.0 - (noise_mm / rms_mm.max(1e-300)).powi(2),
        },
        verdict,
        candidates,
        set: context.set(),
        formula,
        next_cycle,
        not_visible: invisible(problem, &first),
        out_of_reach: problem.out_of_reach.clone(),
    }
}

/// Effects that the model imitates in this cycle.
fn invisible(problem: &Problem<'_>, first: &View) -> Vec<String> {
    let hidden = |(g, score): (usize, &Score)| (score.surviving == 0).then(|| problem.instances[g].id());
    first.named.scores.iter().enumerate().filter_map(hidden).collect()
}

struct Context<'a> {
    problem: &'a Problem<'a>,
    options: &'a Options,
    first: &'a View,
    found: &'a [Item],
    /// True when nothing worth claiming is left beside what was found.
    complete: bool,
    rms_mm: f64,
    noise_mm: f64,
}

impl Context<'_> {
    /// What the search kept comes first, then whatever else has evidence of its own.
    fn candidates(&self) -> Vec<Candidate> {
        let scores = &self.first.named.scores;
        let mut kept: Vec<(usize, Item)> = Vec::new();
        for item in self.found {
            if let What::Named(group) = item.what {
                // Against the present model, or with the other kept ones in it where they hide it.
                let ln_odds = scores[group].ln_odds.max(item.ln_odds);
                kept.push((group, Item { ln_odds, ..item.clone() }));
            }
        }
        kept.sort_by(|a, b| b.1.ln_odds.total_cmp(&a.1.ln_odds));
        let mut rest: Vec<usize> = (0..scores.len())
            .filter(|g| scores[*g].ln_odds > self.options.claim_ln && kept.iter().all(|k| k.0 != *g))
            .collect();
        rest.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
        // Without anything found, single scores above the limit were beaten in the duel or explained by each other.
        rest.truncate(if self.found.is_empty() {
            0
        } else {
            self.options.candidates.saturating_sub(kept.len())
        });
        let rest = rest.into_iter().map(|g| (g, named_item(self.problem, self.first, g)));
        let listed: Vec<_> = kept.into_iter().chain(rest).take(self.options.candidates).collect();
        listed.into_iter().map(|(group, item)| self.candidate(group, &item)).collect()
    }

    /// Model entries of what the search kept.
    fn set(&self) -> Vec<ModelEffect> {
        self.found.iter().flat_map(|item| self.entries(item)).collect()
    }

    fn entries(&self, item: &Item) -> Vec<ModelEffect> {
        match &item.what {
            What::Named(group) => vec![ModelEffect {
                id: self.problem.instances[*group].id(),
                shape: item.shape.clone(),
                ..ModelEffect::default()
            }],
            What::Open(saying) => self.problem.vocabulary.entries(saying, &item.shape),
        }
    }

    fn candidate(&self, group: usize, item: &Item) -> Candidate {
        let problem = self.problem;
        let alone = problem.fit(&item.columns);
        let after_mm = alone.rms_mm;
        let adequate = self.adequate(item, after_mm);
        let instance = &problem.instances[group];
        let confused = self.confused_with(group, item);
        let rivals: Vec<_> = confused.iter().map(|&g| &problem.instances[g]).collect();
        let nothing = DMatrix::zeros(0, problem.experiment.rows());
        let numbers = words::Numbers {
            before_um: self.rms_mm * 1e3,
            after_um: after_mm * 1e3,
            noise_um: self.noise_mm * 1e3,
            holdout_before_um: problem.holdout_rms_mm(&nothing, &self.first.fit.outlier) * 1e3,
            holdout_after_um: problem.holdout_rms_mm(&item.columns, &alone.outlier) * 1e3,
        };
        Candidate {
            effect: instance.id(),
            evidence: item.ln_odds / LN_10,
            rms_um_after: numbers.after_um,
            holdout_rms_um_after: numbers.holdout_after_um,
            explains_fraction: self.explained(after_mm),
            parameters: self.parameters(group, item),
            separate_by: words::separate_by(instance, &rivals),
            confused_with: rivals.iter().map(|instance| instance.id()).collect(),
            adequate,
            why: words::why(instance, &numbers, adequate),
        }
    }

    /// Nothing structured remains with this item alone: it is all that was found, or fits as well as all that was found.
    fn adequate(&self, item: &Item, after_mm: f64) -> bool {
        let all_found = match self.found {
            [only] => only.what == item.what,
            _ => false,
        };
        let like_all_found = || {
            let readings = self.problem.experiment.rows() as f64;
            readings * (after_mm / self.noise_mm).ln() < CONFUSED_LN
        };
        self.complete && !self.found.iter().any(Item::is_open) && (all_found || like_all_found())
    }

    /// Share of the mean square above the noise floor.
    fn explained(&self, after_mm: f64) -> f64 {
        let square = |x: f64| x * x;
        let explainable = square(self.rms_mm) - square(self.noise_mm);
        if explainable <= 0.0 {
            return 0.0;
        }
        ((square(self.rms_mm) - square(after_mm)) / explainable).clamp(0.0, 1.0)
    }

    /// Rivals whose odds are close when the other kept effects are in the model, and effects whose columns coincide with
    /// this one's in this cycle.
    fn confused_with(&self, group: usize, item: &Item) -> Vec<usize> {
        if !self.found.iter().any(|other| other.what == item.what) {
            return Vec::new();
        }
        let problem = self.problem;
        let rows = problem.experiment.rows();
        let others = columns_of(self.found.iter().filter(|other| other.what != item.what), rows);
        let view = View::of(problem, others);
        let (others, scores) = (&view.chosen, &view.named.scores);
        let member = &problem.bank.members[scores[group].member];
        let kept = |g: usize| self.found.iter().any(|other| other.what == What::Named(g));
        let mut confused: Vec<usize> = (0..scores.len())
            .filter(|&g| g != group && !kept(g) && scores[g].surviving > 0)
            .filter(|&g| {
                if scores[g].ln_odds > scores[group].ln_odds - CONFUSED_LN && scores[g].ln_odds > 0.0 {
                    return true;
                }
                let other = problem.named.part(g, scores[g].part).transpose();
                let cosines = member.canonical_correlations(others, &item.columns, &other);
                cosines.len() == item.columns.nrows().min(other.nrows()) && cosines.iter().all(|c| *c > ALIAS)
            })
            .collect();
        confused.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
        confused
    }

    fn parameters(&self, group: usize, item: &Item) -> Vec<CandidateParameter> {
        let problem = self.problem;
        let instance = &problem.instances[group];
        let raw = problem.columns(instance, &item.shape);
        let member = &problem.bank.members[self.first.named.scores[group].member];
        let (values, covariance) = member.fit(&self.first.fit.readings, &raw);
        let seen = |j: usize| covariance[(j, j)] > 0.0 && covariance[(j, j)].is_finite();
        let mut listed: Vec<CandidateParameter> = instance
            .parameters(&problem.experiment.scene)
            .iter()
            .enumerate()
            .map(|(j, parameter)| CandidateParameter {
                name: parameter.name.clone(),
                value: seen(j).then(|| values[j] * parameter.unit.per_inside),
                u: seen(j).then(|| covariance[(j, j)].sqrt() * parameter.unit.per_inside.abs()),
                unit: parameter.unit.symbol.into(),
            })
            .collect();
        for (name, value) in problem.shapes[group].names.iter().zip(&item.shape) {
            listed.push(CandidateParameter {
                name: name.to_string(),
                value: Some(*value),
                u: None,
                unit: Unit::ONE.symbol.into(),
            });
        }
        listed
    }

    /// What was kept without a name, the strongest first; several components of one site are one proposal.
    fn formula(&self) -> Option<FormulaProposal> {
        let item = self.strongest(true)?;
        let What::Open(saying) = &item.what else { return None };
        let vocabulary = &self.problem.vocabulary;
        let family = &vocabulary.families[saying.family];
        let entries = vocabulary.entries(saying, &item.shape);
        let first = entries.first()?.clone();
        let scores = &self.first.named.scores;
        let resembles = (0..scores.len())
            .filter(|&g| scores[g].ln_odds > self.options.claim_ln)
            .max_by(|&a, &b| scores[a].ln_odds.total_cmp(&scores[b].ln_odds))
            .map(|g| self.problem.instances[g].id());
        let after_mm = self.problem.fit(&item.columns).rms_mm;
        let components: Vec<&str> = entries.iter().filter_map(|e| e.component.as_deref()).collect();
        let site = first.site.unwrap_or_default();
        let number = |(number, &value): (&Number, &f64)| ShapeNumber {
            name: number.name.into(),
            value,
            unit: number.unit(),
        };
        let shape: Vec<ShapeNumber> = family.numbers.iter().zip(&item.shape).map(number).collect();
        let lives = words::lives(&site, &components, &words::placed(&family.words, &shape));
        Some(FormulaProposal {
            name: Formula::name_of(&first.id).unwrap_or(&first.id).into(),
            component: first.component.unwrap_or_default(),
            expression: first.expression.unwrap_or_default(),
            shape,
            evidence: item.ln_odds / LN_10,
            rms_um_after: after_mm * 1e3,
            explains_fraction: self.explained(after_mm),
            lives,
            resembles,
            site,
            entries,
        })
    }

    /// True when what has no name explains more than what has one.
    fn formula_leads(&self, candidates: &[Candidate]) -> bool {
        let Some(open) = self.strongest(true) else { return false };
        let named = self.strongest(false).map_or(f64::NEG_INFINITY, |item| item.ln_odds);
        // A named effect beside a phrase that had to be kept is only believed when it explains most on its own.
        let explains = candidates.first().map_or(0.0, |best| best.explains_fraction);
        open.ln_odds > named || explains < MOSTLY
    }

    fn strongest(&self, open: bool) -> Option<&Item> {
        let of_sort = self.found.iter().filter(|item| item.is_open() == open);
        of_sort.max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds))
    }
}
