//! Several missing effects at once: add the best, learn the noise again, score again; at every step the open grammar is compared
//! with the catalogue (docs/design/statistics.md §3, §4).
//!
//! Two effects that hide each other are named together: the best that has something to say for it but not enough is added on trial, and both
//! stay if together they earn both names. A further shape of an effect that is in already (a second lobe number) is no further name: its columns go into
//! the model next to it.

use crate::diagnosis::model_comparison::{Additions, additions};
use crate::diagnosis::named::{price_ln, scored_each};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::Scored;
use crate::diagnosis::view::{Item, What, columns_of};
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

/// Searches next to the model, at most `most` additions. `None` where the noise cannot be learned.
pub fn search(scan: &Scan<'_>, claim_ln: f64, most: usize) -> Option<Found> {
    let rows = scan.remainder.y.len();
    let none = DMatrix::zeros(rows, 0);
    let mut state =
        State { scan, claim_ln, items: Vec::new(), further: none.clone(), views: Views::default() };
    let mut view = state.views.of(scan, none, &scan.first.here.sigma)?;
    let before = view.clone();
    let mut next = state.next(&view);
    let first = next.named.clone();
    let (mut on_trial, mut further): (Option<f64>, usize) = (None, 0);
    let mut open = state.open(&next);
    let mut complete = true;
    while let Some(best) = next.best.take() {
        let ln_odds = best.item.ln_odds;
        let enough = match on_trial {
            None => ln_odds > claim_ln,
            Some(trial) => ln_odds + trial > 2.0 * claim_ln,
        };
        if !enough && (on_trial.is_some() || best.ln_bf <= 0.0 || best.item.is_open()) {
            break;
        }
        if state.items.len() == most {
            complete = !enough;
            break;
        }
        let is_further = enough && state.is_further(&best);
        if is_further {
            state.further = joined(&state.further, &best.item.columns);
            further += 1;
            if further > MOST_FURTHER {
                complete = false;
                break;
            }
        } else {
            state.items.push(best.item.clone());
        }
        let sigma = if enough && state.items.len() > 1 && !is_further {
            state.swap(&best.sigma)
        } else {
            best.sigma.clone()
        };
        let Some(after) = state.views.of(scan, state.chosen(), &sigma) else { break };
        (view, on_trial) = (after, if enough { None } else { Some(ln_odds) });
        next = state.next(&view);
        if enough {
            open = state.open(&next);
        }
    }
    if on_trial.is_some() {
        state.items.pop();
        view = state.views.of(scan, state.chosen(), &view.null.here.sigma)?;
    }
    let State { items, further, views, .. } = state;
    Some(Found { items, complete, open, further, last: view, before, first, views })
}

struct State<'a> {
    scan: &'a Scan<'a>,
    claim_ln: f64,
    items: Vec<Item>,
    further: DMatrix<f64>,
    views: Views,
}

impl State<'_> {
    fn chosen(&self) -> DMatrix<f64> {
        joined(&columns_of(self.items.iter(), self.scan.remainder.y.len()), &self.further)
    }

    /// What could come next. Effects that are in may come again with a further shape, where they have shapes to choose from.
    fn next(&self, view: &Seen) -> Additions {
        let single = |g: &usize| self.scan.named[*g].parts.len() < 2;
        let closed: Vec<usize> = self.taken().into_iter().filter(single).collect();
        additions(self.scan, &self.views, view, &closed, self.claim_ln)
    }

    fn taken(&self) -> Vec<usize> {
        let named = |item: &Item| match item.what {
            What::Named(group) => Some(group),
            What::Open(_) => None,
        };
        self.items.iter().filter_map(named).collect()
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
        next.named.iter().filter_map(group).collect()
    }

    /// Tries each item but the last again, the others in the model: cures a wrong first choice. Gives the noise after it.
    fn swap(&mut self, sigma: &Arc<Sigma>) -> Arc<Sigma> {
        let mut sigma = sigma.clone();
        for i in 0..self.items.len() - 1 {
            let others = self.items.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, item)| item);
            let chosen = joined(&columns_of(others, self.scan.remainder.y.len()), &self.further);
            let Some(view) = self.views.of(self.scan, chosen, &sigma) else { continue };
            let taken: Vec<usize> = (0..self.items.len())
                .filter(|j| *j != i)
                .filter_map(|j| if let What::Named(g) = self.items[j].what { Some(g) } else { None })
                .collect();
            let What::Named(group) = self.items[i].what else { continue };
            let next = additions(self.scan, &self.views, &view, &taken, self.claim_ln);
            let Some(best) = next.best else { continue };
            if best.item.what == self.items[i].what {
                self.items[i] = best.item;
                continue;
            }
            let now = scored_each(self.scan, &view, &[group]);
            let now = now.first().map_or(-price_ln(self.scan, group), |scored| scored.item.ln_odds);
            if best.item.ln_odds > now && (!best.item.is_open() || best.item.ln_odds > now + self.claim_ln) {
                sigma = best.sigma.clone();
                self.items[i] = best.item;
            }
        }
        sigma
    }
}
