//! From scans to the answer: candidates in order, what each would do, what it could be mistaken for, the verdict.

use crate::diagnosis::families::Number;
use crate::diagnosis::model_comparison::named_item;
use crate::diagnosis::options::Options;
use crate::diagnosis::refits::{Explained, Refit, refits};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::search::search;
use crate::diagnosis::verdict::{
    Candidate, Diagnosis, FormulaProposal, NextCycle, ResidualSummary, ShapeNumber, Verdict,
};
use crate::diagnosis::view::{Item, View, What, columns_of};
use crate::diagnosis::words;
use crate::evidence::Score;
use crate::problem::Problem;
use nalgebra::DMatrix;
use std::f64::consts::LN_10;
use trunnion_core::convert::um_from_mm;
use trunnion_effects::{Formula, ModelEffect};

/// Rivals within this ln of the posterior odds are confused (a factor of 20).
const CONFUSED_LN: f64 = 3.0;
/// Columns whose smallest canonical correlation exceeds this coincide in this cycle.
const ALIAS: f64 = 0.999;
/// A named effect that explains at least this share leads, although a part remains.
const MOSTLY: f64 = 0.8;

/// Answers for the model of `problem`.
pub fn answer(problem: &Problem<'_>, scan: &Scan<'_>, options: &Options) -> Diagnosis {
    let nothing = DMatrix::zeros(0, scan.experiment.rows());
    let first = View::of(scan, nothing);
    let (found, complete) = search(scan, &first, options.claim_ln, options.look_ahead);
    let all_found_mm = scan.fit(&columns_of(found.iter(), scan.experiment.rows())).rms_mm;
    let floor_mm = all_found_mm.min(first.fit.rms_mm);
    let context = Context { problem, scan, options, first: &first, found: &found, complete, floor_mm };

    let listed = context.listed();
    let refits = context.refits(&listed);
    let explained = refits.explained(problem);
    let candidates = context.candidates(&listed, &refits.candidates, &explained);
    let formula = context.formula(refits.formula.as_ref(), &explained);
    let verdict = match (candidates.is_empty(), context.formula_leads(&listed)) {
        (_, true) => Verdict::UnnamedStructure,
        (false, false) => Verdict::MissingEffect,
        (true, false) if listed.is_empty() => Verdict::NoiseFloor,
        // Something was found that cannot be added.
        (true, false) => Verdict::UnnamedStructure,
    };
    let next_cycle = candidates
        .first()
        .filter(|candidate| !candidate.separate_by.is_empty())
        .map(|candidate| NextCycle::advice(candidate.separate_by.clone()));
    let fit = problem.fit();
    Diagnosis {
        model: problem.model().effects.iter().map(|effect| effect.id.clone()).collect(),
        residual: ResidualSummary {
            rms_um: um_from_mm(fit.rms_mm),
            holdout_rms_um: fit.holdout_rms_mm().map(um_from_mm),
            holdout_unit: fit.holdout.map(|holdout| holdout.left_out),
            noise_um: fit.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
            unexplained_fraction: explained.together(),
        },
        verdict,
        candidates,
        set: context.set(),
        formula,
        next_cycle,
        not_visible: invisible(scan, &first),
        out_of_reach: scan.out_of_reach.clone(),
    }
}

/// Effects that the model imitates in this cycle.
fn invisible(scan: &Scan<'_>, first: &View) -> Vec<String> {
    let hidden = |(g, score): (usize, &Score)| (score.surviving == 0).then(|| scan.instances[g].id());
    first.named.iter().enumerate().filter_map(hidden).collect()
}

struct Context<'a> {
    problem: &'a Problem<'a>,
    scan: &'a Scan<'a>,
    options: &'a Options,
    first: &'a View,
    found: &'a [Item],
    /// True when nothing worth claiming is left next to what was found.
    complete: bool,
    /// What the scan leaves with all that was found, mm rms.
    floor_mm: f64,
}

/// The fits with what is listed.
struct Refits {
    /// In the order of the list.
    candidates: Vec<Option<Refit>>,
    formula: Option<Refit>,
    /// With everything that was found together.
    set: Option<Refit>,
}

impl Refits {
    fn explained(&self, problem: &Problem<'_>) -> Explained {
        let before_mm = problem.fit().rms_mm;
        let all = self.candidates.iter().flatten().chain(&self.formula).chain(&self.set);
        Explained { before_mm, least_mm: all.map(Refit::rms_mm).fold(before_mm, f64::min) }
    }
}

impl Context<'_> {
    /// What the search kept comes first, then whatever else has evidence of its own.
    fn listed(&self) -> Vec<(usize, Item)> {
        let scores = &self.first.named;
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
        // Without anything found, single scores above the limit lost a comparison or are explained by each other.
        rest.truncate(if self.found.is_empty() {
            0
        } else {
            self.options.candidates.saturating_sub(kept.len())
        });
        let rest = rest.into_iter().map(|g| (g, named_item(self.scan, self.first, g)));
        kept.into_iter().chain(rest).take(self.options.candidates).collect()
    }

    /// Fits the model with each of the listed, with the formula, and with all that was found.
    fn refits(&self, listed: &[(usize, Item)]) -> Refits {
        let alone = |(group, _): &(usize, Item)| {
            let id = self.scan.instances[*group].id();
            vec![ModelEffect { id, ..ModelEffect::default() }]
        };
        let mut additions: Vec<_> = listed.iter().map(alone).collect();
        let formula = self.strongest(true).map(|item| self.entries(item));
        let set = (self.found.len() > 1).then(|| self.set());
        let (with_formula, with_set) = (formula.is_some(), set.is_some());
        additions.extend(formula);
        additions.extend(set);
        let mut candidates = refits(self.problem, additions);
        let set = if with_set { candidates.pop().flatten() } else { None };
        let formula = if with_formula { candidates.pop().flatten() } else { None };
        Refits { candidates, formula, set }
    }

    /// One for each of the listed that can be added.
    fn candidates(
        &self,
        listed: &[(usize, Item)],
        refits: &[Option<Refit>],
        explained: &Explained,
    ) -> Vec<Candidate> {
        let with = listed.iter().zip(refits);
        with.filter_map(|((group, item), refit)| {
            Some(self.candidate(*group, item, refit.as_ref()?, explained))
        })
        .collect()
    }

    /// Model entries of what the search kept.
    fn set(&self) -> Vec<ModelEffect> {
        self.found.iter().flat_map(|item| self.entries(item)).collect()
    }

    fn entries(&self, item: &Item) -> Vec<ModelEffect> {
        match &item.what {
            What::Named(group) => vec![ModelEffect {
                id: self.scan.instances[*group].id(),
                shape: item.shape.clone(),
                ..ModelEffect::default()
            }],
            What::Open(term) => self.scan.vocabulary.entries(term, &item.shape),
        }
    }

    fn candidate(&self, group: usize, item: &Item, refit: &Refit, explained: &Explained) -> Candidate {
        let scan = self.scan;
        let adequate = self.adequate(item);
        let instance = &scan.instances[group];
        let confused = self.confused_with(group, item);
        let rivals: Vec<_> = confused.iter().map(|&g| &scan.instances[g]).collect();
        let fit = self.problem.fit();
        let numbers = words::Numbers {
            before_um: um_from_mm(fit.rms_mm),
            after_um: refit.rms_um(),
            repeatability_um: fit.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
            holdout: fit.holdout.zip(refit.holdout_rms_um()),
        };
        Candidate {
            effect: instance.id(),
            evidence: item.ln_odds / LN_10,
            rms_um_after: refit.rms_um(),
            holdout_rms_um_after: refit.holdout_rms_um(),
            explains_fraction: explained.by(refit.rms_mm()),
            parameters: refit.parameters(),
            separate_by: words::separate_by(instance, &rivals),
            confused_with: rivals.iter().map(|instance| instance.id()).collect(),
            adequate,
            why: words::why(instance, &numbers, adequate),
        }
    }

    /// Nothing structured remains with this item alone: it is all that was found, or fits as well as all that was found.
    fn adequate(&self, item: &Item) -> bool {
        let all_found = match self.found {
            [only] => only.what == item.what,
            _ => false,
        };
        let like_all_found = || {
            let readings = self.scan.experiment.rows() as f64;
            let after_mm = self.scan.fit(&item.columns).rms_mm;
            readings * (after_mm / self.floor_mm).ln() < CONFUSED_LN
        };
        self.complete && !self.found.iter().any(Item::is_open) && (all_found || like_all_found())
    }

    /// Rivals whose odds are close when the other kept effects are in the model, and effects whose columns coincide with
    /// this one's in this cycle.
    fn confused_with(&self, group: usize, item: &Item) -> Vec<usize> {
        if !self.found.iter().any(|other| other.what == item.what) {
            return Vec::new();
        }
        let scan = self.scan;
        let rows = scan.experiment.rows();
        let others = columns_of(self.found.iter().filter(|other| other.what != item.what), rows);
        let view = View::of(scan, others);
        let (others, scores) = (&view.chosen, &view.named);
        let member = &scan.bank.members[scores[group].member];
        let kept = |g: usize| self.found.iter().any(|other| other.what == What::Named(g));
        let mut confused: Vec<usize> = (0..scores.len())
            .filter(|&g| g != group && !kept(g) && scores[g].surviving > 0)
            .filter(|&g| {
                if scores[g].ln_odds > scores[group].ln_odds - CONFUSED_LN && scores[g].ln_odds > 0.0 {
                    return true;
                }
                let other = scan.named.part(g, scores[g].part).transpose();
                let cosines = member.canonical_correlations(others, &item.columns, &other);
                cosines.len() == item.columns.nrows().min(other.nrows()) && cosines.iter().all(|c| *c > ALIAS)
            })
            .collect();
        confused.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
        confused
    }

    /// What was kept without a name, the strongest first; several components of one site are one proposal.
    fn formula(&self, refit: Option<&Refit>, explained: &Explained) -> Option<FormulaProposal> {
        let (item, refit) = (self.strongest(true)?, refit?);
        let What::Open(term) = &item.what else { return None };
        let vocabulary = &self.scan.vocabulary;
        let family = &vocabulary.families[term.family];
        let entries = vocabulary.entries(term, &item.shape);
        let first = entries.first()?.clone();
        let scores = &self.first.named;
        let resembles = (0..scores.len())
            .filter(|&g| scores[g].ln_odds > self.options.claim_ln)
            .max_by(|&a, &b| scores[a].ln_odds.total_cmp(&scores[b].ln_odds))
            .map(|g| self.scan.instances[g].id());
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
            rms_um_after: refit.rms_um(),
            holdout_rms_um_after: refit.holdout_rms_um(),
            explains_fraction: explained.by(refit.rms_mm()),
            lives,
            resembles,
            site,
            entries,
        })
    }

    /// True when what has no name explains more than what has one.
    fn formula_leads(&self, listed: &[(usize, Item)]) -> bool {
        let Some(open) = self.strongest(true) else { return false };
        let named = self.strongest(false).map_or(f64::NEG_INFINITY, |item| item.ln_odds);
        // A named effect next to a term that had to be kept is only believed when it explains most on its own.
        let scanned = Explained { before_mm: self.first.fit.rms_mm, least_mm: self.floor_mm };
        let explains =
            listed.first().map_or(0.0, |(_, item)| scanned.by(self.scan.fit(&item.columns).rms_mm));
        open.ln_odds > named || explains < MOSTLY
    }

    fn strongest(&self, open: bool) -> Option<&Item> {
        let of_sort = self.found.iter().filter(|item| item.is_open() == open);
        of_sort.max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds))
    }
}
