//! From scans to the answer: candidates in order, what each would do, what it could be mistaken for, the verdict.

mod remains;

use crate::diagnosis::constancy::is_constant;
use crate::diagnosis::families::Number;
use crate::diagnosis::judged::{OpenEffect, Verdict};
use crate::diagnosis::judgement::{
    is_noise_unknown, more_than_noise, noise_sizes, nothing_claimed, noticeable_um, open_effects,
    units_differ,
};
use crate::diagnosis::kept::{Kept, Refits};
use crate::diagnosis::options::{DiagnoseError, Options};
use crate::diagnosis::refits::{Explained, Refit, Unfitted};
use crate::diagnosis::rivals::confused_with;
use crate::diagnosis::scan::Scan;
use crate::diagnosis::search::{Found, search};
use crate::diagnosis::verdict::{
    Candidate, CandidateParameter, Diagnosis, FormulaProposal, NextCycle, ResidualSummary, ShapeNumber,
    Together,
};
use crate::diagnosis::view::{Item, What, columns_of};
use crate::diagnosis::views::Views;
use crate::diagnosis::words;
use crate::problem::Problem;
use crate::spectrum::Wave;
use nalgebra::DMatrix;
use std::f64::consts::LN_10;
use trunnion_core::convert::um_from_mm;
use trunnion_effects::Formula;

/// A named effect that explains at least this share leads, although a part remains.
const MOSTLY: f64 = 0.8;
/// An expression next to a named effect is proposed when it explains a share that is not printed as 0 %.
const SHOWN: f64 = 0.005;

/// Answers for the model of `problem`, unless a named effect that was found cannot be the cause. `views`: what was looked at in this scan before.
pub fn answer(
    problem: &Problem<'_>,
    scan: &Scan<'_>,
    views: &Views,
    options: &Options,
) -> Result<Answer, DiagnoseError> {
    let found = search(scan, views, options).ok_or(DiagnoseError::NoNoise)?;
    let all_found_mm = scan.left(&columns_of(found.items.iter(), scan.remainder.y.len()));
    let alone_mm = scan.left(&DMatrix::zeros(scan.remainder.y.len(), 0));
    let is_constant = is_constant(scan, &found, options.claim_ln);
    let kept = Kept::new(problem, scan, &found);
    let context = Context {
        problem,
        scan,
        options,
        found: &found,
        kept: &kept,
        floor_mm: all_found_mm,
        alone_mm,
        is_constant,
    };

    let listed = context.listed();
    let refits = kept.refits(&listed);
    let explained = refits.explained(problem);
    if let Some((effect, why)) = kept.only_resembles(&listed, &refits) {
        return Ok(Answer::Resembles { effect, why });
    }
    if let Some((effect, why)) = kept.not_the_cause(&listed, &refits.candidates) {
        return Ok(Answer::Without { with: kept.found_with(&effect), effect, why });
    }
    if let Some(effect) = kept.predicts_nothing(&listed, &refits) {
        return Ok(Answer::NotAdded { effect });
    }
    let mut candidates = context.candidates(&listed, &refits, &explained);
    let formula_leads = context.formula_leads(&listed);
    if formula_leads {
        // None of them is the answer: the one that does most comes closest to it.
        candidates.sort_by(|a, b| a.rms_um_after.total_cmp(&b.rms_um_after));
    }
    let formula = context
        .formula(refits.formula.as_ref(), &explained, &candidates)
        .filter(|formula| formula_leads || formula.explains_fraction >= SHOWN);
    let fit = problem.fit();
    let (verdict, mut why, mut next) = match (candidates.is_empty(), formula_leads) {
        (_, true) => (Verdict::UnnamedStructure, String::new(), String::new()),
        (false, false) => (Verdict::MissingEffect, String::new(), String::new()),
        (true, false) if listed.is_empty() => nothing_claimed(scan, fit, &found),
        // Something was found that cannot be added.
        (true, false) => (Verdict::UnnamedStructure, String::new(), String::new()),
    };
    // What was only listed, and no model holds, is no part of the answer.
    let found_ids: Vec<String> = kept.set().into_iter().map(|entry| entry.id).collect();
    let unfitted = refits.unfitted.iter().filter(|one| one.is_among(&found_ids)).map(Unfitted::words);
    let remains = refits.all_found().filter(|_| verdict == Verdict::MissingEffect);
    let remains = remains.and_then(|refit| context.what_remains(refit));
    let of_sign = kept.meaning_of_sign(&listed, &refits.candidates);
    for sentence in unfitted.chain(of_sign).chain(remains) {
        why = format!("{why} {sentence}").trim_start().into();
    }
    let is_repeat = match verdict {
        Verdict::UnnamedStructure => formula.is_none(),
        Verdict::MissingEffect => {
            refits.all_found().is_some_and(|refit| is_noise_unknown(fit, refit.rms_mm()))
        }
        _ => false,
    };
    if is_repeat && next.is_empty() {
        next = NextCycle::repeat(problem.experiment()).suggestion;
    }
    let next_cycle = candidates
        .iter()
        .map(|candidate| candidate.separate_by.clone())
        .find(|suggestion| !suggestion.is_empty())
        .or_else(|| Some(next).filter(|next| !next.is_empty()))
        .map(NextCycle::advice);
    let not_visible = invisible(scan, &found, &candidates);
    let open = |(group, ln_bf): (usize, f64)| OpenEffect {
        effect: scan.named[group].instance.id(),
        evidence: ln_bf / LN_10,
    };
    Ok(Answer::Diagnosis(Box::new(Diagnosis {
        model: problem.model().effects.iter().map(|effect| effect.id.clone()).collect(),
        residual: ResidualSummary {
            rms_um: um_from_mm(fit.rms_mm),
            holdout_rms_um: fit.holdout_rms_mm().map(um_from_mm),
            holdout_unit: fit.holdout.map(|holdout| holdout.left_out),
            noise_um: fit.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
            noise_readings: fit.repeatability.map(|noise| noise.readings),
            unexplained_fraction: explained.by_nothing(),
        },
        verdict,
        why,
        noise: noise_sizes(scan, &found.last.null),
        noticeable_um: noticeable_um(scan, &found, options.claim_ln),
        undecided: open_effects(scan, &found).map(open).collect(),
        candidates,
        set: kept.set(),
        together: refits.set.as_ref().map(|refit| context.together(refit, &explained)),
        formula,
        next_cycle,
        not_visible,
        out_of_reach: scan.out_of_reach.clone(),
    })))
}

/// What a search came to.
pub enum Answer {
    Diagnosis(Box<Diagnosis>),
    /// Search again without this effect: it fits best, but cannot be the cause.
    Without {
        effect: String,
        why: String,
        /// What was found together with it: only this is not what it leaves behind.
        with: Vec<String>,
    },
    /// Search again without this effect, which only resembles another: it cannot be in a model, or not at that size.
    Resembles {
        effect: String,
        /// Of weight where nothing else is found.
        why: String,
    },
    /// Search again and do not add this effect: a model that has it next to the others that were found is no better.
    NotAdded {
        effect: String,
    },
}

/// Effects that the model imitates in this cycle. What was found is no part of the model: what only that imitates is confounded with it,
/// and shown. So is what a candidate is or is confounded with.
fn invisible(scan: &Scan<'_>, found: &Found, candidates: &[Candidate]) -> Vec<String> {
    let is_shown =
        |id: &String| candidates.iter().any(|one| one.effect == *id || one.confused_with.contains(id));
    let named = scan.named.iter().zip(&found.before.named);
    let imitated = named.filter(|(_, score)| !score.visible).map(|(named, _)| named.instance.id());
    imitated.filter(|id| !is_shown(id)).collect()
}

/// `wave` of an effect with the uncertainty that its frequency has in the fit, drift and offsets included.
fn as_fitted(wave: Wave, effect: &str, parameters: &[CandidateParameter]) -> Wave {
    let is_it = |p: &&CandidateParameter| {
        p.effect == effect && p.value.is_some_and(|value| (value - wave.value).abs() < wave.u)
    };
    let of_fit = parameters.iter().filter(is_it).find_map(|p| p.u);
    Wave { u: of_fit.unwrap_or(wave.u), ..wave }
}

struct Context<'a> {
    problem: &'a Problem<'a>,
    scan: &'a Scan<'a>,
    options: &'a Options,
    found: &'a Found,
    kept: &'a Kept<'a>,
    /// What the scan leaves with all that was found, and with nothing, mm rms.
    floor_mm: f64,
    alone_mm: f64,
    /// Whether nothing that was found changes with time or place.
    is_constant: bool,
}

impl Context<'_> {
    /// What the search kept comes first, then whatever else has evidence of its own.
    fn listed(&self) -> Vec<(usize, Item)> {
        let first =
            |group: usize| self.found.first.iter().find(|scored| scored.item.what == What::Named(group));
        let mut kept: Vec<(usize, Item)> = Vec::new();
        for item in &self.found.items {
            if let Some(group) = item.what.group() {
                // Against the present model, or with the other kept ones in it where they hide it.
                let alone = first(group).map_or(f64::NEG_INFINITY, |scored| scored.item.ln_odds);
                kept.push((group, Item { ln_odds: alone.max(item.ln_odds), ..item.clone() }));
            }
        }
        kept.sort_by(|a, b| b.1.ln_odds.total_cmp(&a.1.ln_odds));
        // Without anything found, single scores above the limit lost a comparison or are explained by each other.
        let most = if self.found.items.is_empty() { 0 } else { self.options.candidates };
        let is_kept = |group: usize| kept.iter().any(|(kept, _)| *kept == group);
        let rest = self.found.first.iter().filter(|scored| scored.item.ln_odds > self.options.claim_ln);
        let rest: Vec<(usize, Item)> = rest
            .filter_map(|scored| Some((scored.item.what.group()?, scored.item.clone())))
            .filter(|(group, _)| !is_kept(*group))
            .collect();
        kept.into_iter().chain(rest).take(most).collect()
    }

    /// One for each of the listed that can be added.
    fn candidates(&self, listed: &[(usize, Item)], refits: &Refits, explained: &Explained) -> Vec<Candidate> {
        let with = listed.iter().zip(&refits.candidates);
        with.filter_map(|((group, item), refit)| {
            let (refit, set) = (refit.as_ref()?, refits.set.as_ref());
            Some(self.candidate(*group, item, [refit, set.unwrap_or(refit)], explained))
        })
        .collect()
    }

    /// The fits with it alone and, where more was found, with all that was found.
    fn candidate(
        &self,
        group: usize,
        item: &Item,
        [refit, with_all]: [&Refit; 2],
        explained: &Explained,
    ) -> Candidate {
        let scan = self.scan;
        let explains_all =
            self.adequate(item) && more_than_noise(self.problem.fit(), refit.rms_mm()).is_none();
        // As the model with it is judged once it is added.
        let differ = if explains_all { units_differ(refit.fit()) } else { None };
        let instance = &scan.named[group].instance;
        let is_found = self.found.items.iter().any(|other| other.what == item.what);
        let confused =
            if is_found { confused_with(scan, self.found, item, self.options.claim_ln) } else { Vec::new() };
        let rivals: Vec<_> = confused.iter().map(|&g| &scan.named[g].instance).collect();
        let shown = if is_found { with_all } else { refit };
        let doubts = shown.doubts(self.problem, &instance.id());
        let no_lag = shown.no_lag(self.problem.experiment(), &instance.id());
        let (parameters, mut waves) = self.parameters(refit);
        let own = waves.iter().position(|(effect, _)| *effect == instance.id());
        let period = own.map(|at| waves.swap_remove(at).1);
        Candidate {
            effect: instance.id(),
            evidence: item.ln_odds / LN_10,
            rms_um_after: refit.rms_um(),
            holdout_rms_um_after: refit.holdout_rms_um(),
            explains_fraction: explained.by(refit.rms_mm()),
            parameters,
            separate_by: words::separate_by(instance, &rivals),
            confused_with: rivals.iter().map(|instance| instance.id()).collect(),
            explains_all: explains_all && differ.is_none(),
            remarks: period.iter().map(Wave::words).chain(no_lag).chain(differ).collect(),
            doubts,
            seen_together: shown.seen_together(&instance.id()).cloned().collect(),
            period,
        }
    }

    /// Parameters of what was added; the waves that these are of, each with its effect.
    fn parameters(&self, refit: &Refit) -> (Vec<CandidateParameter>, Vec<(String, Wave)>) {
        let parameters = refit.parameters();
        let of_shape = |(effect, shape): (&str, &[f64])| {
            let named = self.scan.named.iter().find(|named| named.instance.id() == effect)?;
            let wave = Wave::of_effect(&self.scan.residual, &named.instance, shape)?;
            Some((effect.to_string(), as_fitted(wave, effect, &parameters)))
        };
        let waves = refit.shapes().filter_map(of_shape).collect();
        (parameters, waves)
    }

    /// What everything found does in one model. Further shapes are no part of it: the model has an effect once.
    fn together(&self, refit: &Refit, explained: &Explained) -> Together {
        let explains_all = self.what_is_left(refit).is_empty();
        Together {
            rms_um: refit.rms_um(),
            holdout_rms_um: refit.holdout_rms_um(),
            explains_fraction: explained.by(refit.rms_mm()),
            parameters: self.parameters(refit).0,
            explains_all,
            adequate: explains_all && !self.is_of_another_cause(refit),
        }
    }

    /// What was kept without a name, the strongest first; several components of one site are one proposal.
    fn formula(
        &self,
        refit: Option<&Refit>,
        explained: &Explained,
        candidates: &[Candidate],
    ) -> Option<FormulaProposal> {
        let (item, refit) = (self.kept.strongest_open()?, refit?);
        let What::Open(term) = &item.what else { return None };
        let family = &self.scan.vocabulary.families[term.family];
        let entries = self.kept.entries_of(item).to_vec();
        let first = entries.first()?.clone();
        let leaves_less = |a: &&Candidate, b: &&Candidate| a.rms_um_after.total_cmp(&b.rms_um_after);
        let resembles = candidates.iter().min_by(leaves_less).map(|candidate| candidate.effect.clone());
        let components: Vec<&str> = entries.iter().filter_map(|e| e.component.as_deref()).collect();
        let site = first.site.unwrap_or_default();
        let number = |(number, &value): (&Number, &f64)| ShapeNumber {
            name: number.name.into(),
            value,
            unit: number.unit(),
        };
        let shape: Vec<ShapeNumber> = family.numbers.iter().zip(&item.shape).map(number).collect();
        let location = words::location(&site, &components, &words::placed(&family.words, &shape));
        Some(FormulaProposal {
            name: Formula::name_of(&first.id).unwrap_or(&first.id).into(),
            component: first.component.unwrap_or_default(),
            expression: first.expression.unwrap_or_default(),
            shape,
            evidence: item.ln_odds / LN_10,
            rms_um_after: refit.rms_um(),
            holdout_rms_um_after: refit.holdout_rms_um(),
            explains_fraction: explained.by(refit.rms_mm()),
            location,
            resembles,
            site,
            entries,
        })
    }

    /// True when what has no name explains more than what has one.
    fn formula_leads(&self, listed: &[(usize, Item)]) -> bool {
        let Some(open) = self.kept.strongest_open() else { return false };
        // The odds that are printed: next to a part of itself without a name, a name may have less of its own.
        let is_found = |(group, _): &&(usize, Item)| self.kept.names().any(|name| name == *group);
        let named = listed.iter().find(is_found).map_or(f64::NEG_INFINITY, |(_, item)| item.ln_odds);
        // A named effect next to a term that had to be kept is only believed when it explains most on its own.
        let scanned = Explained { before_mm: self.alone_mm, least_mm: self.floor_mm };
        let explains = listed.first().map_or(0.0, |(_, item)| scanned.by(self.scan.left(&item.columns)));
        open.ln_odds > named || explains < MOSTLY
    }
}
