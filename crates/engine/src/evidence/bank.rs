//! The noise bank, and scores averaged over it.

use super::algebra::{log_sum_exp, parallel};
use super::context::{Blocks, Context};
use super::library::{Entry, Library, Natural};
use super::member::Prepared;
use super::part::PartScore;
use crate::noise::machine_noise::Order;
use nalgebra::{DMatrix, DVector};

/// Repeatable motions of a rotary axis are natural up to this share of the noise variance: every bearing, encoder and gear has some.
/// Not quite half the standard deviation where nothing else is at work; next to a larger effect they are not what is missing.
const NATURAL_SHARE: f64 = 0.2;
const ALIKE_SHARE: f64 = 0.12;
const NATURAL_SHARE_BESIDE: f64 = 0.6;

/// Blocks of many samples see structure far below their floor, which is itself no white noise: less than this share of it is not claimed.
const NOTICEABLE_SHARE: f64 = 0.25;
/// The member without any correlated part; every scan has it.
pub const WHITE: usize = 0;

/// The bank, ready for scans.
pub struct Bank {
    /// Its members.
    pub members: Vec<Prepared>,
    rows: usize,
    /// True for the base model: nothing else has been found.
    bare: bool,
    least_share: f64,
}

/// Readings and chosen columns under every member.
pub struct Situation {
    contexts: Vec<Context>,
    /// ln marginal likelihood of "nothing more" for each member, over the variances of the repeatable motions.
    pub nothing: Vec<f64>,
    /// ln Σ of them over the bank.
    total: f64,
    alone: bool,
    /// Share below which nothing is claimed.
    least_share: f64,
}

/// Score of one group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// ln Bayes factor after its prior, averaged over noise and shapes.
    pub ln_odds: f64,
    /// Best shape.
    pub part: usize,
    /// Bank member under which it is best.
    pub member: usize,
    /// Index of the variance of the repeatable motions under which it is best.
    pub motion: usize,
    /// Columns that survive the projection, best shape.
    pub surviving: usize,
    /// ln marginal likelihood of the best member and shape.
    pub log_likelihood: f64,
    /// The same without the price of its columns: how well it fits.
    pub fit_ln: f64,
    /// Mean square that it explains in a reading, relative to the white part of the noise.
    pub share: f64,
}

impl Score {
    const NONE: Self = Self {
        ln_odds: f64::NEG_INFINITY,
        part: 0,
        member: 0,
        motion: 0,
        surviving: 0,
        log_likelihood: f64::NEG_INFINITY,
        fit_ln: f64::NEG_INFINITY,
        share: 0.0,
    };
}

impl Situation {
    /// The members under which "nothing more" is likeliest, best first.
    pub fn likeliest(&self) -> Vec<usize> {
        let mut members: Vec<usize> = (0..self.nothing.len()).collect();
        members.sort_by(|&a, &b| self.nothing[b].total_cmp(&self.nothing[a]));
        members
    }
}

impl Bank {
    /// Whitens and projects the base columns (column × row) under every member. `motions` are the random columns; `bare` is true where
    /// the base is that of a machine without any effect.
    pub fn new(order: &Order, base: &DMatrix<f64>, motions: &DMatrix<f64>, bare: bool) -> Self {
        let noises = order.bank();
        let members = parallel(noises.len(), |i| Prepared::new(order, noises[i], base, motions));
        let least_share = if order.on_the_fly { NOTICEABLE_SHARE } else { 0.0 };
        Self { members, rows: base.ncols(), bare, least_share }
    }

    /// Parameters of the base model that can be seen.
    pub fn base_rank(&self) -> usize {
        self.members[0].base_rank()
    }

    /// Every member.
    pub fn all(&self) -> Vec<usize> {
        (0..self.members.len()).collect()
    }

    /// Blocks of a library under the members listed.
    pub fn blocks(&self, library: &Library, members: &[usize]) -> Vec<Blocks> {
        parallel(members.len(), |i| self.members[members[i]].blocks(library))
    }

    /// Places readings `y` and the columns `chosen` (column × row) under every member.
    pub fn situation(&self, y: &DVector<f64>, chosen: &DMatrix<f64>) -> Situation {
        let contexts = parallel(self.members.len(), |m| self.members[m].context(y, chosen));
        let of_member = |context: &Context| log_sum_exp(context.soft.iter().map(|soft| soft.nothing));
        let nothing: Vec<f64> = contexts.iter().map(of_member).collect();
        let total = log_sum_exp(nothing.iter().copied());
        let alone = self.bare && chosen.nrows() == 0;
        Situation { contexts, nothing, total, alone, least_share: self.least_share }
    }

    /// Scores every group of `library` under the members listed.
    pub fn scan(
        &self,
        library: &Library,
        members: &[usize],
        blocks: &[&Blocks],
        situation: &Situation,
    ) -> Vec<Score> {
        let scored = parallel(members.len(), |i| {
            let m = members[i];
            self.members[m].scan(library, blocks[i], &situation.contexts[m])
        });
        let mut first = 0;
        let scores = library.groups.iter().map(|group| {
            let parts = first..first + group.parts.len();
            first = parts.end;
            let of_member = |i: usize| {
                scored[i].iter().map(|of_motion| &of_motion[parts.clone()]).collect::<Vec<&[PartScore]>>()
            };
            let of_members: Vec<_> = (0..members.len()).map(|i| (members[i], of_member(i))).collect();
            combined(situation, &of_members, group.prior_ln, group.natural)
        });
        scores.collect()
    }

    /// Score of one set of columns (column × row) under the members listed.
    pub fn weigh(
        &self,
        columns: &DMatrix<f64>,
        prior_ln: f64,
        natural: Natural,
        members: &[usize],
        situation: &Situation,
    ) -> Score {
        let entry = Entry { parts: vec![columns.transpose()], prior_ln, natural };
        let library = Library::new(self.rows, vec![entry]);
        let blocks = self.blocks(&library, members);
        self.scan(&library, members, &blocks.iter().collect::<Vec<_>>(), situation)[0]
    }

    /// How well columns (column × row) fit under one member and variance of the repeatable motions, for refining shape numbers:
    /// −½ ν ln(1 − R²).
    pub fn gain_ln(
        &self,
        columns: &DMatrix<f64>,
        member: usize,
        motion: usize,
        situation: &Situation,
    ) -> f64 {
        let entry = Entry { parts: vec![columns.transpose()], prior_ln: 0.0, natural: Natural::No };
        let library = Library::new(self.rows, vec![entry]);
        let prepared = &self.members[member];
        let scored = prepared.scan(&library, &prepared.blocks(&library), &situation.contexts[member]);
        scored[motion][0].gain_ln
    }
}

/// One group from the scores of its parts by member and variance of the repeatable motions.
fn combined(
    situation: &Situation,
    of_members: &[(usize, Vec<&[PartScore]>)],
    prior_ln: f64,
    natural: Natural,
) -> Score {
    let mut best = Score::NONE;
    let mut terms = Vec::new();
    let mut parts = 1;
    for (member, of_motion) in of_members {
        for (motion, scored) in of_motion.iter().enumerate() {
            let nothing = situation.contexts[*member].soft[motion].nothing;
            parts = scored.len().max(1);
            for (part, score) in scored.iter().enumerate() {
                let log_likelihood = nothing + score.ln_bf;
                terms.push(log_likelihood);
                if log_likelihood > best.log_likelihood {
                    let fit_ln = nothing + score.gain_ln;
                    let surviving = score.surviving;
                    best = Score { part, member: *member, motion, surviving, log_likelihood, fit_ln, ..best };
                }
            }
        }
    }
    let scored: Vec<f64> = of_members.iter().map(|(member, _)| situation.nothing[*member]).collect();
    // Under a part of the bank the odds are those of that part.
    let nothing = if scored.len() == situation.nothing.len() {
        situation.total
    } else {
        log_sum_exp(scored.iter().copied())
    };
    best.ln_odds = log_sum_exp(terms.iter().copied()) - (parts as f64).ln() - nothing + prior_ln;
    // What is natural is judged by its plain size in the readings, against the white part of the likeliest noise.
    let of = |member: usize| of_members.iter().find(|(m, _)| *m == member).map(|(_, of_motion)| of_motion);
    if let (Some(plain), Some(likely)) = (of(WHITE), of(best.member)) {
        best.share = plain[0][best.part].explained / likely[best.motion][best.part].noise.max(1e-300);
    }
    let least = match (natural, situation.alone) {
        (Natural::No, _) => situation.least_share,
        (Natural::Alike, true) => ALIKE_SHARE,
        (Natural::Yes, true) => NATURAL_SHARE,
        (Natural::Yes | Natural::Alike, false) => NATURAL_SHARE_BESIDE,
    };
    if best.surviving == 0 || best.share < least {
        best.ln_odds = f64::NEG_INFINITY;
    }
    best
}
