//! Several missing effects at once: add the best, learn the noise again, score again; at every step the open grammar is compared
//! with the catalogue (docs/design/statistics.md §3, §4).
//!
//! Two effects that hide each other are named together: the best that has something to say for it but not enough is added on trial, and both
//! stay if together they earn both names. A further shape of an effect that is in already (a second lobe number) is no further name: its columns go into
//! the model next to it.
//!
//! What was added first, or on trial, may have its share from what came later. So each name must stand at last: with everything else that was
//! found in the model and the noise learned again, it is worth claiming, with the further shapes that were found of it if need be. The weakest
//! that is not is taken out, and the search goes on without it.

use crate::diagnosis::model_comparison::{Additions, additions};
use crate::diagnosis::named::{named, price_ln, scored_each};
use crate::diagnosis::options::Options;
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::Scored;
use crate::diagnosis::sparse::sparse_ln_odds;
use crate::diagnosis::view::{Item, View, What, columns_of};
use crate::diagnosis::views::{Seen, Views};
use crate::evidence::joined;
use crate::noise::learned::sigma::Sigma;
use nalgebra::DMatrix;
use std::rc::Rc;
use std::sync::Arc;

/// Further shapes of effects that are in, at most.
const MOST_FURTHER: usize = 3;

/// What a search found.
pub struct Found {
    /// Additions that together explain what is left.
    pub items: Vec<Item>,
    /// True when nothing worth claiming is left next to them.
    pub complete: bool,
    /// Named effects that have something to say for them, but not enough: with ln Bayes factors, best first.
    pub open: Vec<(usize, f64)>,
    /// Further shapes of effects among the items, weighted.
    pub further: DMatrix<f64>,
    /// The noise with all items.
    pub last: Rc<Seen>,
    /// The noise with no item in the model, and what was looked at next to it.
    pub before: Rc<Seen>,
    pub first: Vec<Scored>,
    /// Whatever else was looked at.
    pub views: Views,
}

/// Searches next to the model, at most `options.look_ahead` additions. `views`: what was looked at in this scan before. `None` where the noise
/// cannot be learned.
pub fn search(scan: &Scan<'_>, views: &Views, options: &Options) -> Option<Found> {
    let (claim_ln, most) = (options.claim_ln, options.look_ahead);
    let none = DMatrix::zeros(scan.remainder.y.len(), 0);
    let is_out = |group: &usize| options.not_added.contains(&scan.named[*group].instance.id());
    let mut state = State {
        scan,
        claim_ln,
        items: Vec::new(),
        further: Vec::new(),
        fallen: (0..scan.named.len()).filter(is_out).map(|group| (group, 0.0)).collect(),
        views: views.clone(),
    };
    let before = state.views.of(scan, none, &scan.first.here.sigma)?;
    let first = named(scan, &before, &[], claim_ln);
    let mut view = before.clone();
    loop {
        let grown = state.grow(view, most)?;
        let each = state.each_next_to_others(&grown.view);
        let weakest = each.iter().min_by(|a, b| a.margin_ln.total_cmp(&b.margin_ln));
        let Some(fallen) = weakest.filter(|one| state.items.len() > 1 && one.margin_ln <= 0.0) else {
            for one in &each {
                state.items[one.at].ln_odds = one.ln_odds;
            }
            let further = columns_of(state.further.iter(), scan.remainder.y.len());
            let State { items, views, .. } = state;
            let Grown { view: last, complete, open } = grown;
            return Some(Found { items, complete, open, further, last, before, first, views });
        };
        state.take_out(fallen);
        view = state.views.of(scan, state.chosen(), &grown.view.null.here.sigma)?;
    }
}

/// Where additions ended.
struct Grown {
    view: Rc<Seen>,
    complete: bool,
    open: Vec<(usize, f64)>,
}

/// An item that is looked at with all others in the model.
struct NextToOthers {
    at: usize,
    group: usize,
    ln_bf: f64,
    /// With those of its further shapes that make it stand.
    ln_odds: f64,
    /// How far it is above what is worth claiming: where shapes stand together, above that of all of them, as two names on trial.
    margin_ln: f64,
}

struct State<'a> {
    scan: &'a Scan<'a>,
    claim_ln: f64,
    items: Vec<Item>,
    /// Further shapes of items.
    further: Vec<Item>,
    /// Effects that did not stand next to the others, with ln Bayes factors.
    fallen: Vec<(usize, f64)>,
    views: Views,
}

impl State<'_> {
    /// Adds while something is worth it.
    fn grow(&mut self, mut view: Rc<Seen>, most: usize) -> Option<Grown> {
        let mut next = self.next(&view);
        let mut on_trial: Option<f64> = None;
        let mut open = self.open(&next);
        let mut complete = true;
        while let Some(best) = next.best.take() {
            let ln_odds = best.item.ln_odds;
            let enough = match on_trial {
                None => ln_odds > self.claim_ln,
                Some(trial) => ln_odds + trial > 2.0 * self.claim_ln,
            };
            if !enough && (on_trial.is_some() || best.ln_bf <= 0.0 || best.item.is_open()) {
                break;
            }
            if self.items.len() == most {
                complete = !enough;
                break;
            }
            let is_further = enough && self.is_further(&best);
            if is_further {
                self.further.push(best.item.clone());
                if self.further.len() > MOST_FURTHER {
                    complete = false;
                    break;
                }
            } else {
                self.items.push(best.item.clone());
            }
            let sigma = if enough && self.items.len() > 1 && !is_further {
                self.swap(best.sigma())
            } else {
                best.sigma().clone()
            };
            let Some(after) = self.views.of(self.scan, self.chosen(), &sigma) else { break };
            (view, on_trial) = (after, if enough { None } else { Some(ln_odds) });
            next = self.next(&view);
            if enough {
                open = self.open(&next);
            }
        }
        if on_trial.is_some() {
            self.items.pop();
            view = self.views.of(self.scan, self.chosen(), &view.null.here.sigma)?;
        }
        Some(Grown { view, complete, open })
    }

    /// What each name has to say for it next to all others. `view`: with all of them.
    fn each_next_to_others(&self, view: &View) -> Vec<NextToOthers> {
        (0..self.items.len()).filter_map(|at| self.next_to_others(at, view)).collect()
    }

    /// One of the names, all others in the model: its best shape, then as many further ones as were found of it, each next to those before.
    fn next_to_others(&self, at: usize, view: &View) -> Option<NextToOthers> {
        let group = self.items[at].what.group()?;
        let is_own = |item: &&Item| item.what == What::Named(group);
        let others = self.items.iter().chain(&self.further).filter(|item| !is_own(item));
        let mut chosen = columns_of(others, self.scan.remainder.y.len());
        let mut found: Option<NextToOthers> = None;
        let (mut odds_ln, mut margin_ln) = (0.0, 0.0);
        for _ in 0..=self.further.iter().filter(is_own).count() {
            let next = self.views.of(self.scan, chosen.clone(), &view.null.here.sigma)?;
            let Some(scored) = scored_each(self.scan, &next, &[group]).pop() else { break };
            odds_ln += scored.item.ln_odds;
            margin_ln += scored.item.ln_odds - self.claim_ln;
            chosen = joined(&chosen, &scored.item.columns);
            match &mut found {
                None => {
                    let ln_bf = scored.ln_bf;
                    found = Some(NextToOthers { at, group, ln_bf, ln_odds: odds_ln, margin_ln });
                    if margin_ln > 0.0 {
                        break;
                    }
                }
                Some(best) if margin_ln > best.margin_ln => {
                    (best.ln_odds, best.margin_ln) = (odds_ln, margin_ln)
                }
                Some(_) => {}
            }
        }
        found
    }

    /// Takes a name out for good, and all further shapes: those that still count are found again.
    fn take_out(&mut self, fallen: &NextToOthers) {
        self.items.remove(fallen.at);
        self.further.clear();
        self.fallen.push((fallen.group, fallen.ln_bf));
    }

    fn chosen(&self) -> DMatrix<f64> {
        columns_of(self.items.iter().chain(&self.further), self.scan.remainder.y.len())
    }

    /// What could come next. Effects that are in may come again with a further shape, where they have shapes to choose from.
    fn next(&self, view: &Seen) -> Additions {
        let single = |g: &usize| self.scan.named[*g].parts.len() < 2;
        let fallen = self.fallen.iter().map(|(group, _)| *group);
        let closed: Vec<usize> = self.taken().into_iter().filter(single).chain(fallen).collect();
        additions(self.scan, &self.views, view, &closed, self.claim_ln)
    }

    fn taken(&self) -> Vec<usize> {
        self.items.iter().filter_map(|item| item.what.group()).collect()
    }

    fn is_further(&self, best: &Scored) -> bool {
        self.items.iter().any(|item| !item.is_open() && item.what == best.item.what)
    }

    fn open(&self, next: &Additions) -> Vec<(usize, f64)> {
        let taken = self.taken();
        let group = |scored: &Scored| match scored.item.what {
            What::Named(group) if scored.ln_bf > 0.0 && scored.noticeable && !taken.contains(&group) => {
                Some((group, scored.ln_bf))
            }
            _ => None,
        };
        // What did not stand still has something to say for it.
        let fallen = self.fallen.iter().copied().filter(|(_, ln_bf)| *ln_bf > 0.0);
        next.named.iter().filter_map(group).chain(fallen).collect()
    }

    /// Tries each item but the last again, the others in the model: cures a wrong first choice. Gives the noise after it.
    fn swap(&mut self, sigma: &Arc<Sigma>) -> Arc<Sigma> {
        let mut sigma = sigma.clone();
        for i in 0..self.items.len() - 1 {
            let others = self.items.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, item)| item);
            let chosen = columns_of(others.chain(&self.further), self.scan.remainder.y.len());
            let Some(view) = self.views.of(self.scan, chosen, &sigma) else { continue };
            let taken: Vec<usize> = (0..self.items.len())
                .filter(|j| *j != i)
                .filter_map(|j| self.items[j].what.group())
                .chain(self.fallen.iter().map(|(group, _)| *group))
                .collect();
            let Some(group) = self.items[i].what.group() else { continue };
            let next = additions(self.scan, &self.views, &view, &taken, self.claim_ln);
            let Some(best) = next.best else { continue };
            if best.item.what == self.items[i].what {
                self.items[i] = best.item;
                continue;
            }
            let now = scored_each(self.scan, &view, &[group]);
            let now_ln = now.first().map_or(-price_ln(self.scan, group), |now| match best.item.what {
                What::Named(_) => now.item.ln_odds,
                What::Open(_) => sparse_ln_odds(self.scan, now, Some(&best.noise)),
            });
            let beat_ln = if best.item.is_open() { now_ln + self.claim_ln } else { now_ln };
            if best.item.ln_odds > beat_ln {
                sigma = best.sigma().clone();
                self.items[i] = best.item;
            }
        }
        sigma
    }
}
