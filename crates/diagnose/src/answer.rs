//! From scans to the answer: candidates in order, what each would do, what it could be mistaken for, the verdict.

use crate::diagnosis::{
    Candidate, CandidateParameter, Diagnosis, FormulaProposal, NextCycle, ResidualSummary, Verdict,
};
use crate::evidence::Score;
use crate::problem::Problem;
use crate::search::{Item, Scans, What, columns_of, named_item, refine, scan, scan_named, scan_open, search};
use crate::{Options, words};
use nalgebra::DMatrix;
use std::f64::consts::LN_10;
use trunnion_effects::{Model, ModelEffect, Unit};

/// Rivals within this ln of the posterior odds are confused (a factor of 20).
const CONFUSED_LN: f64 = 3.0;
/// Columns whose smallest canonical correlation exceeds this coincide in this cycle.
const ALIAS: f64 = 0.999;
/// A named effect that explains at least this share leads, although a part remains.
const MOSTLY: f64 = 0.8;

/// Answers for the model of `problem`.
pub fn answer(problem: &Problem<'_>, model: &Model, options: &Options) -> Diagnosis {
    let nothing = DMatrix::zeros(0, problem.experiment.rows());
    let first = scan(problem, &nothing);
    let rms_mm = first.fit.rms_mm;
    let not_visible = invisible(problem, &first);
    let again = Scans { fit: problem.fit(&nothing), named: first.named.clone(), open: first.open };
    let found = search(problem, again, options.claim_ln, options.look_ahead);
    let noise_mm = problem.fit(&columns_of(found.iter(), problem.experiment.rows())).rms_mm.min(rms_mm);
    let context = Context { problem, options, first: &first, found: &found, rms_mm, noise_mm };

    let candidates = context.candidates();
    let (formula, formula_leads) = context.formula();
    // A named effect beside a phrase that had to be kept is only believed when it explains most on its own.
    let named_leads = candidates.first().is_some_and(|best| best.explains_fraction >= MOSTLY);
    let formula_leads = formula_leads || (formula.is_some() && !named_leads);
    let verdict = match (candidates.is_empty(), formula_leads) {
        (_, true) => Verdict::UnnamedStructure,
        (false, false) => Verdict::MissingEffect,
        (true, false) => Verdict::NoiseFloor,
    };
    let next_cycle = candidates
        .first()
        .filter(|candidate| !candidate.separate_by.is_empty())
        .map(|candidate| NextCycle { suggestion: candidate.separate_by.clone() });
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
        not_visible,
        out_of_reach: problem.out_of_reach.clone(),
    }
}

/// Effects that the model imitates in this cycle.
fn invisible(problem: &Problem<'_>, first: &Scans) -> Vec<String> {
    let hidden = |(g, score): (usize, &Score)| (score.surviving == 0).then(|| problem.instances[g].id());
    first.named.scores.iter().enumerate().filter_map(hidden).collect()
}

struct Context<'a> {
    problem: &'a Problem<'a>,
    options: &'a Options,
    first: &'a Scans,
    found: &'a [Item],
    rms_mm: f64,
    noise_mm: f64,
}

impl Context<'_> {
    /// What the search kept comes first, then whatever else has evidence of its own.
    fn candidates(&self) -> Vec<Candidate> {
        let scores = &self.first.named.scores;
        let mut kept: Vec<(usize, f64, Item)> = Vec::new();
        for item in self.found {
            if let What::Named(group) = item.what {
                kept.push((group, self.weight_together(item), item.clone()));
            }
        }
        kept.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut rest: Vec<usize> = (0..scores.len())
            .filter(|g| scores[*g].ln_odds > self.options.claim_ln && kept.iter().all(|k| k.0 != *g))
            .collect();
        rest.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
        let nothing = DMatrix::zeros(0, self.problem.experiment.rows());
        // Without anything found, single scores above the limit were beaten in the duel or explained by each other.
        let rest = rest.into_iter().filter(|_| !self.found.is_empty()).map(|g| {
            let item = named_item(self.problem, g, &scores[g]);
            let item = refine(self.problem, item, &self.first.fit, &nothing, scores[g].member);
            (g, scores[g].ln_odds, item)
        });
        let listed: Vec<_> = kept.into_iter().chain(rest).take(self.options.candidates).collect();
        listed.into_iter().map(|(group, ln_odds, item)| self.candidate(group, ln_odds, &item)).collect()
    }

    /// Model entries of what the search kept.
    fn set(&self) -> Vec<ModelEffect> {
        let entry = |item: &Item| match item.what {
            What::Named(group) => ModelEffect {
                id: self.problem.instances[group].id(),
                shape: item.shape.clone(),
                ..ModelEffect::default()
            },
            What::Open(phrase, variant) => {
                let text = &self.problem.vocabulary.phrases[phrase];
                let name = format!("{}-{}", text.site.replace(':', "-").to_lowercase(), text.component);
                ModelEffect {
                    id: format!("formula:{name}"),
                    site: Some(text.site.clone()),
                    component: Some(text.component.into()),
                    expression: Some(text.expression(variant)),
                    ..ModelEffect::default()
                }
            }
        };
        self.found.iter().map(entry).collect()
    }

    /// ln odds of a kept effect: against the present model, or with the other kept ones in it where they hide it.
    fn weight_together(&self, item: &Item) -> f64 {
        match item.what {
            What::Named(group) => self.first.named.scores[group].ln_odds.max(item.ln_odds),
            What::Open(..) => item.ln_odds,
        }
    }

    fn candidate(&self, group: usize, ln_odds: f64, item: &Item) -> Candidate {
        let problem = self.problem;
        let alone = scan_named(problem, &item.columns);
        let others = alone.named.scores.iter().enumerate().filter(|(g, _)| *g != group);
        let named_left = others.map(|(_, score)| score.ln_odds).fold(f64::NEG_INFINITY, f64::max);
        let limit = self.options.claim_ln;
        let adequate = named_left <= limit
            && scan_open(problem, &item.columns, &alone.fit, &alone.named)
                .is_none_or(|(score, _)| score.ln_odds <= limit);
        let after_mm = alone.fit.rms_mm;
        let instance = &problem.instances[group];
        let confused = self.confused_with(group, item);
        let rivals: Vec<_> = confused.iter().map(|&g| &problem.instances[g]).collect();
        let numbers = words::Numbers {
            before_um: self.rms_mm * 1e3,
            after_um: after_mm * 1e3,
            noise_um: self.noise_mm * 1e3,
            holdout_before_um: problem
                .holdout_rms_mm(&DMatrix::zeros(0, problem.experiment.rows()), &self.first.fit.outlier)
                * 1e3,
            holdout_after_um: problem.holdout_rms_mm(&item.columns, &alone.fit.outlier) * 1e3,
        };
        Candidate {
            effect: instance.id(),
            evidence: ln_odds / LN_10,
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
        let scans = scan_named(problem, &others);
        let scores = &scans.named.scores;
        let member = &problem.bank.members[scores[group].member];
        let kept = |g: usize| self.found.iter().any(|other| other.what == What::Named(g));
        let mut confused: Vec<usize> = (0..scores.len())
            .filter(|&g| g != group && !kept(g) && scores[g].surviving > 0)
            .filter(|&g| {
                if scores[g].ln_odds > scores[group].ln_odds - CONFUSED_LN && scores[g].ln_odds > 0.0 {
                    return true;
                }
                let other = problem.named.part(g, scores[g].part).transpose();
                let cosines = member.canonical_correlations(&others, &item.columns, &other);
                cosines.len() == item.columns.nrows().min(other.nrows()) && cosines.iter().all(|c| *c > ALIAS)
            })
            .collect();
        confused.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
        confused
    }

    fn parameters(&self, group: usize, item: &Item) -> Vec<CandidateParameter> {
        let problem = self.problem;
        let instance = &problem.instances[group];
        let raw = problem.experiment.columns(instance, &item.shape).transpose();
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

    /// The best phrase among what the search kept, and whether it leads the named effects.
    fn formula(&self) -> (Option<FormulaProposal>, bool) {
        let open = |item: &&Item| matches!(item.what, What::Open(..));
        let best = |items: &mut dyn Iterator<Item = f64>| items.fold(f64::NEG_INFINITY, f64::max);
        let Some(item) = self.found.iter().filter(open).max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds)) else {
            return (None, false);
        };
        let What::Open(mut phrase, mut variant) = item.what else { return (None, false) };
        let mut columns = item.columns.clone();
        let mut ln_odds = item.ln_odds;
        // What was kept may only patch a named effect; offered is what does most on its own.
        if let Some((score, alone)) =
            self.first.open.filter(|(score, _)| score.ln_odds > self.options.claim_ln)
        {
            let other = self.problem.vocabulary.library.part(alone, score.part).transpose();
            if self.problem.fit(&other).rms_mm < self.problem.fit(&columns).rms_mm {
                (phrase, variant, columns, ln_odds) = (alone, score.part, other, score.ln_odds);
            }
        }
        let named = best(&mut self.found.iter().filter(|i| !open(i)).map(|i| i.ln_odds));
        let leads = item.ln_odds > named;
        let text = &self.problem.vocabulary.phrases[phrase];
        let scores = &self.first.named.scores;
        let resembles = (0..scores.len())
            .filter(|&g| scores[g].ln_odds > self.options.claim_ln)
            .max_by(|&a, &b| scores[a].ln_odds.total_cmp(&scores[b].ln_odds))
            .map(|g| self.problem.instances[g].id());
        let after_mm = self.problem.fit(&columns).rms_mm;
        let proposal = FormulaProposal {
            name: format!("{}-{}", text.site.replace(':', "-").to_lowercase(), text.component),
            site: text.site.clone(),
            component: text.component.into(),
            expression: text.expression(variant),
            evidence: ln_odds / LN_10,
            rms_um_after: after_mm * 1e3,
            explains_fraction: self.explained(after_mm),
            lives: words::lives(&text.site, text.component, &text.words),
            resembles,
        };
        (Some(proposal), leads)
    }
}
