//! What an experiment would show of the rivals: expected ln Bayes factors of each against nothing and against every other.

use super::design::CycleDesign;
use super::information::Information;
use super::knowledge::Knowledge;
use super::options::ENOUGH_LN;
use super::rivals::Rivals;
use super::separation::{expected_ln, with_unknown_noise};
use crate::Experiment;
use std::ops::Range;

/// Expected ln Bayes factors in one situation.
#[derive(Clone, Debug)]
pub(super) struct Utility {
    /// Of each rival against nothing.
    pub seen_ln: Vec<f64>,
    /// `against_ln[a][b]`: of rival a, if it is the truth, against rival b.
    pub against_ln: Vec<Vec<f64>>,
}

impl Utility {
    /// ln by which a rival is distinguished from all others and from none.
    pub(super) fn discriminated_ln(&self, rival: usize) -> f64 {
        self.against_ln[rival].iter().copied().fold(self.seen_ln[rival], f64::min)
    }

    /// Every two rivals with the ln by which they are separated, whichever is the truth.
    pub(super) fn pairs(&self) -> Vec<(usize, usize, f64)> {
        let rivals = self.seen_ln.len();
        let ln = |a: usize, b: usize| self.against_ln[a][b].min(self.against_ln[b][a]);
        (0..rivals)
            .flat_map(|a| (a + 1..rivals).map(move |b| (a, b)))
            .map(|(a, b)| (a, b, ln(a, b)))
            .collect()
    }
}

impl CycleDesign<'_> {
    /// What an experiment would show of the rivals.
    pub(super) fn utility(&self, experiment: &Experiment, knowledge: &Knowledge) -> Utility {
        let shaped = self.shaped(&experiment.scene, Some(&knowledge.shapes));
        let model = self.present.model_columns(experiment);
        let information = Information::new(experiment, &model, &shaped.parts, None);
        let rivals = 0..self.instances.len();
        let nothing = vec![f64::INFINITY; rivals.len()];
        let mut utility =
            Utility { seen_ln: vec![0.0; rivals.len()], against_ln: vec![nothing; rivals.len()] };
        for a in rivals.clone() {
            let own =
                information.parts.get(shaped.of_rival[a].start).filter(|_| !shaped.of_rival[a].is_empty());
            let own = own.filter(|own| !own.is_empty());
            // A rival may take refuge in another noise model, at the price of explaining the present data worse with it.
            let least = |own: &Range<usize>, other: Option<&Range<usize>>| -> f64 {
                let one = |m: usize| {
                    let (price_ln, variance) = knowledge.noises[m];
                    let view = &information.views[m];
                    let left = view.left_by(own, other) / variance;
                    let ln = expected_ln(&left, &self.known(a, m, knowledge, &experiment.scene));
                    price_ln + with_unknown_noise(ln, information.rows.saturating_sub(view.rank))
                };
                (0..information.views.len()).map(one).fold(f64::INFINITY, f64::min)
            };
            utility.seen_ln[a] = own.map_or(0.0, |own| least(own, None));
            for b in rivals.clone().filter(|&b| b != a) {
                let parts = shaped.of_rival[b].clone();
                let against = |own| {
                    parts
                        .map(|part| least(own, Some(&information.parts[part])))
                        .fold(utility.seen_ln[a], f64::min)
                };
                utility.against_ln[a][b] = own.map_or(0.0, against);
            }
        }
        utility
    }

    /// What is to be made large: how far every two are apart, or how much of what was invisible is seen and separated.
    pub(super) fn gain(&self, utility: &Utility) -> f64 {
        match self.rivals {
            Rivals::Separate(_) => {
                let pairs = utility.pairs();
                pairs.iter().map(|pair| pair.2.min(ENOUGH_LN)).sum::<f64>() / pairs.len().max(1) as f64
            }
            Rivals::Reveal(_) => {
                let rivals = 0..self.entries.len();
                rivals
                    .map(|i| {
                        0.5 * (utility.seen_ln[i].min(ENOUGH_LN) + utility.discriminated_ln(i).min(ENOUGH_LN))
                    })
                    .sum()
            }
        }
    }
}
