//! What a search kept, as additions to the model: the fits with each of it and with all, and what they say against a name.

use crate::diagnosis::entries::entries;
use crate::diagnosis::refits::{Explained, Refit, Unfitted, errors, refits};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::search::Found;
use crate::diagnosis::signs::{self, meaning_of_sign};
use crate::diagnosis::view::{Item, What};
use crate::fit::errors::Errors;
use crate::problem::Problem;
use trunnion_effects::{Formula, Instance, ModelEffect};

/// The fits with what is listed.
pub struct Refits {
    /// In the order of the list.
    pub candidates: Vec<Option<Refit>>,
    pub formula: Option<Refit>,
    /// With everything that was found together.
    pub set: Option<Refit>,
    /// Whether everything found is the first of the candidates.
    only: bool,
    /// With everything but one of the names, where that is more than one thing.
    but: Vec<(usize, Errors)>,
    /// Those that failed.
    pub unfitted: Vec<Unfitted>,
}

impl Refits {
    /// With everything that was found, be it one name or more.
    pub fn all_found(&self) -> Option<&Refit> {
        self.set.as_ref().or_else(|| self.only.then(|| self.candidates.first()?.as_ref())?)
    }

    pub fn explained(&self, problem: &Problem<'_>) -> Explained {
        let before_mm = problem.fit().rms_mm;
        let all = self.candidates.iter().flatten().chain(&self.formula).chain(&self.set);
        Explained { before_mm, least_mm: all.map(Refit::rms_mm).fold(before_mm, f64::min) }
    }
}

/// What was found next to the model of `problem`.
pub struct Kept<'a> {
    problem: &'a Problem<'a>,
    scan: &'a Scan<'a>,
    found: &'a Found,
    /// Model entries of each item found.
    entries: Vec<Vec<ModelEffect>>,
}

impl<'a> Kept<'a> {
    pub fn new(problem: &'a Problem<'a>, scan: &'a Scan<'a>, found: &'a Found) -> Self {
        let entries = entries(scan, &problem.model().effects, &found.items);
        Self { problem, scan, found, entries }
    }

    /// Fits the model with each of the listed, with the formula, and with all that was found.
    pub fn refits(&self, listed: &[(usize, Item)]) -> Refits {
        let alone = |(group, _): &(usize, Item)| {
            let id = self.scan.named[*group].instance.id();
            vec![ModelEffect { id, ..ModelEffect::default() }]
        };
        let mut additions: Vec<_> = listed.iter().map(alone).collect();
        let formula = self.strongest_open().map(|item| self.entries_of(item).to_vec());
        let set = (self.found.items.len() > 1).then(|| self.set_as_added(None));
        let (with_formula, with_set) = (formula.is_some(), set.is_some());
        additions.extend(formula);
        additions.extend(set);
        let fits = refits(self.problem, additions);
        // Of two things each is fitted alone anyhow.
        let names: Vec<usize> = if self.found.items.len() > 2 { self.names().collect() } else { Vec::new() };
        let but: Vec<_> = names.iter().map(|group| self.set_as_added(Some(*group))).collect();
        let of_names = names.into_iter().zip(errors(self.problem, &but));
        let but = of_names.filter_map(|(group, errors)| Some((group, errors?))).collect();
        let mut unfitted = Vec::new();
        let fitted = |refit: Result<Refit, Unfitted>| refit.map_err(|failed| unfitted.push(failed)).ok();
        let mut candidates: Vec<_> = fits.into_iter().map(fitted).collect();
        let set = if with_set { candidates.pop().flatten() } else { None };
        let formula = if with_formula { candidates.pop().flatten() } else { None };
        let is_first = |item: &Item| listed.first().is_some_and(|(_, first)| first.what == item.what);
        let only = matches!(&self.found.items[..], [item] if is_first(item));
        Refits { candidates, formula, set, only, but, unfitted }
    }

    /// The last of the names with which the model, as a person adds it, is no better than with the others that were found: the veto of
    /// what was not seen (docs/design/statistics.md §5).
    pub fn predicts_nothing(&self, listed: &[(usize, Item)], refits: &Refits) -> Option<String> {
        let with = refits.set.as_ref()?.errors();
        let alone = |other: &Item| match other.what {
            What::Open(_) => refits.formula.as_ref().map(Refit::errors),
            What::Named(other) => {
                let at = listed.iter().position(|(group, _)| *group == other)?;
                refits.candidates[at].as_ref().map(Refit::errors)
            }
        };
        let without = |name: usize| match &self.found.items[..] {
            [one, other] => alone(if one.what == What::Named(name) { other } else { one }),
            _ => refits.but.iter().find(|(group, _)| *group == name).map(|(_, errors)| *errors),
        };
        let is_name = |group: &usize| self.names().any(|name| name == *group);
        let in_vain = |group: &usize| without(*group).is_some_and(|without| !with.are_below(&without));
        let mut names = listed.iter().rev().map(|(group, _)| *group).filter(is_name);
        names.find(in_vain).map(|group| self.scan.named[group].instance.id())
    }

    /// Named effects that were found.
    pub fn names(&self) -> impl Iterator<Item = usize> {
        self.found.items.iter().filter_map(|item| item.what.group())
    }

    /// What was found, each with its own fit.
    fn found_refits<'r>(
        &'r self,
        listed: &'r [(usize, Item)],
        refits: &'r [Option<Refit>],
    ) -> impl Iterator<Item = (&'r Instance, &'r Refit)> {
        let is_found = |item: &Item| self.found.items.iter().any(|other| other.what == item.what);
        let found = listed.iter().zip(refits).filter(move |((_, item), _)| is_found(item));
        found.filter_map(|((group, _), refit)| Some((&self.scan.named[*group].instance, refit.as_ref()?)))
    }

    /// The first that was found and cannot be the cause, and why.
    pub fn not_the_cause(
        &self,
        listed: &[(usize, Item)],
        refits: &[Option<Refit>],
    ) -> Option<(String, String)> {
        let scene = &self.problem.experiment().scene;
        self.found_refits(listed, refits).find_map(|(instance, refit)| {
            let display = self.scan.remainder.coarse_display.as_ref();
            let within_display = || refit.within_step(instance, scene, display?.step_mm);
            let unseen = || refit.unseen(instance);
            let beyond = refit.beyond_physical(instance, scene, false);
            let why = beyond.or_else(within_display).or_else(unseen)?;
            Some((instance.id(), why))
        })
    }

    /// The first that was found and only resembles another, and why: no model holds it, or none at that size.
    pub fn only_resembles(&self, listed: &[(usize, Item)], refits: &Refits) -> Option<(String, String)> {
        let scene = &self.problem.experiment().scene;
        let mut of_size = self.found_refits(listed, &refits.candidates);
        let too_large = of_size.find_map(|(instance, refit)| {
            Some((instance.id(), refit.beyond_physical(instance, scene, true)?))
        });
        too_large.or_else(|| {
            let mut ids = self.names().map(|group| self.scan.named[group].instance.id());
            ids.find_map(|id| {
                let failed = refits.unfitted.iter().find(|unfitted| unfitted.is_of(&id))?;
                Some((id, failed.words()))
            })
        })
    }

    /// What the signs of what is in the model, else of what was found, say of the machine.
    pub fn meaning_of_sign(&self, listed: &[(usize, Item)], refits: &[Option<Refit>]) -> Option<String> {
        let scene = &self.problem.experiment().scene;
        let mut found = self.found_refits(listed, refits);
        signs::of_model(self.problem)
            .or_else(|| found.find_map(|(instance, refit)| meaning_of_sign(refit.fit(), instance, scene)))
    }

    /// Ids of what was found with an effect in the model.
    pub fn found_with(&self, effect: &str) -> Vec<String> {
        self.set().into_iter().map(|entry| entry.id).filter(|id| id != effect).collect()
    }

    /// Model entries of what the search kept.
    pub fn set(&self) -> Vec<ModelEffect> {
        self.entries.concat()
    }

    /// The same as a person adds them, but for one: shape numbers of the catalogue's effects are for the fit to find, as of a candidate alone.
    fn set_as_added(&self, but: Option<usize>) -> Vec<ModelEffect> {
        let as_added = |entry: &ModelEffect| match Formula::name_of(&entry.id) {
            Some(_) => entry.clone(),
            None => ModelEffect { id: entry.id.clone(), ..ModelEffect::default() },
        };
        let is_in = |item: &Item| but.is_none_or(|group| item.what != What::Named(group));
        let kept = self.found.items.iter().zip(&self.entries).filter(|(item, _)| is_in(item));
        kept.flat_map(|(_, entries)| entries).map(as_added).collect()
    }

    /// Those of one of the items found.
    pub fn entries_of(&self, item: &Item) -> &[ModelEffect] {
        let at = self.found.items.iter().position(|other| std::ptr::eq(other, item));
        at.map_or(&[], |at| &self.entries[at])
    }

    /// Without a name.
    pub fn strongest_open(&self) -> Option<&Item> {
        let open = self.found.items.iter().filter(|item| item.is_open());
        open.max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds))
    }
}
