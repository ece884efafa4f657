//! Views kept while a scan lasts: exchanging a first choice, looking for rivals and a search that may not add a name come back to columns
//! that were looked at before.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::Scored;
use crate::diagnosis::view::{View, add_once};
use crate::evidence::parallel;
use crate::noise::learned::sigma::Sigma;
use nalgebra::DMatrix;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Deref;
use std::rc::Rc;
use std::sync::Arc;

/// All that were looked at in one scan.
#[derive(Clone, Default)]
pub struct Views(Rc<RefCell<Vec<Rc<Seen>>>>);

/// A view, with the effects that were looked at next to it.
pub struct Seen {
    view: View,
    scored: RefCell<BTreeMap<usize, Option<Scored>>>,
}

impl Views {
    /// The readings with columns in the model. `start`: a noise near by; where none was learned with these columns before, it is learned from
    /// there or from whichever of the others comes nearer.
    pub fn of(&self, scan: &Scan<'_>, chosen: DMatrix<f64>, start: &Arc<Sigma>) -> Option<Rc<Seen>> {
        if let Some(seen) = self.0.borrow().iter().find(|seen| seen.chosen == chosen) {
            return Some(seen.clone());
        }
        let mut near = vec![start.clone()];
        self.0.borrow().iter().for_each(|seen| add_once(&mut near, &seen.null.here.sigma));
        let view = View::of(scan, chosen, near)?;
        let seen = Rc::new(Seen { view, scored: RefCell::default() });
        self.0.borrow_mut().push(seen.clone());
        Some(seen)
    }
}

impl Seen {
    /// What `score` says of each group, asked once for each.
    pub fn scored(
        &self,
        groups: &[usize],
        score: impl Fn(&View, usize) -> Option<Scored> + Sync,
    ) -> Vec<Scored> {
        let is_new = |group: &usize| !self.scored.borrow().contains_key(group);
        let new: Vec<usize> = groups.iter().copied().filter(is_new).collect();
        let view = &self.view;
        let scores = parallel(new.len(), |i| score(view, new[i]));
        let mut scored = self.scored.borrow_mut();
        scored.extend(new.into_iter().zip(scores));
        groups.iter().filter_map(|group| scored[group].clone()).collect()
    }
}

impl Deref for Seen {
    type Target = View;

    fn deref(&self) -> &View {
        &self.view
    }
}
