//! Variances of the parts of a machine's noise, as the residual of a fit shows them.
//!
//! Posterior means under Σ = σ² (I + Σ_k θ_k Z_k Z_kᵀ + c L Lᵀ) with the likelihood of [`crate::noise::likelihood`].
//!
//! Prior of every θ and c, independent: a machine has the part or has it not (one to one); if it has, the ratio √θ of its
//! standard deviation to that of the white noise is half-Cauchy of scale 1 [Gelman, Bayesian Analysis 1 (2006) 515]. Without "has it
//! not", parts too small to be seen would widen every interval of a machine that lacks them.
//! Mean over a grid of half decades in θ: from the best member to all whose weight is not negligible.

use crate::noise::likelihood::{Member, Products, Projected, Residual};
use std::collections::{BTreeMap, BTreeSet, btree_map::Entry};
use std::f64::consts::FRAC_2_PI;

/// Smallest and largest θ of the grid, and steps a decade.
const DECADES: [i32; 2] = [-3, 3];
const PER_DECADE: i32 = 2;
/// Prior probability that a machine has a part.
const HAS_IT: f64 = 0.5;
/// Members lighter than this share of the heaviest are not followed further.
const LIGHT: f64 = 0.1;
/// A scan along one variance ends where the logarithm has fallen by this.
const HOPELESS: f64 = 15.0;
/// Rounds of climbing along one variance after the other.
const MOST_CLIMBS: usize = 4;

/// Posterior means of the variances per reading, mm².
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variances {
    pub white: f64,
    /// One for each kind.
    pub kinds: Vec<f64>,
    pub levers: f64,
}

/// Variances that explain the residual.
pub(crate) fn variances(residual: &Residual<'_>) -> Variances {
    let mut bank = Bank::new(Products::new(residual));
    bank.climb();
    bank.spread();
    bank.mean()
}

/// One value of θ in the grid.
struct Level {
    theta: f64,
    prior_ln: f64,
}

fn levels() -> Vec<Level> {
    let count = (DECADES[1] - DECADES[0]) * PER_DECADE;
    let theta = |step: f64| 10f64.powf(f64::from(DECADES[0]) + step / f64::from(PER_DECADE));
    let below = |step: f64| FRAC_2_PI * theta(step).sqrt().atan();
    let mut levels = vec![Level { theta: 0.0, prior_ln: (1.0 - HAS_IT).ln() }];
    for step in 0..=count {
        let from = if step == 0 { 0.0 } else { below(f64::from(step) - 0.5) };
        let to = if step == count { 1.0 } else { below(f64::from(step) + 0.5) };
        levels.push(Level { theta: theta(f64::from(step)), prior_ln: (HAS_IT * (to - from)).ln() });
    }
    levels
}

/// Level of every kind that can be sized, then of the levers if there are any.
type Place = Vec<usize>;

struct Bank {
    products: Products,
    levels: Vec<Level>,
    members: BTreeMap<Place, Member>,
    best: Place,
    best_ln: f64,
    /// Projected products at each level of the levers.
    projected: BTreeMap<usize, Projected>,
}

impl Bank {
    fn new(products: Products) -> Self {
        let best = vec![0; products.kinds.len() + usize::from(!products.squares.is_empty())];
        let (members, projected) = (BTreeMap::new(), BTreeMap::new());
        let mut bank = Self {
            products,
            levels: levels(),
            members,
            best: best.clone(),
            best_ln: f64::NEG_INFINITY,
            projected,
        };
        bank.visit(&best);
        bank
    }

    fn visit(&mut self, place: &Place) -> f64 {
        if let Some(member) = self.members.get(place) {
            return member.ln;
        }
        let (products, levels) = (&self.products, &self.levels);
        let of_levers = place.get(products.kinds.len()).copied().unwrap_or(0);
        let projected = match self.projected.entry(of_levers) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(products.project(levels[of_levers].theta)),
        };
        let mut member = projected.member(products, |kind| levels[place[kind]].theta);
        member.ln += place.iter().map(|&level| levels[level].prior_ln).sum::<f64>();
        let ln = member.ln;
        if ln > self.best_ln {
            (self.best_ln, self.best) = (ln, place.clone());
        }
        self.members.insert(place.clone(), member);
        ln
    }

    /// To the best member, along one variance after the other.
    fn climb(&mut self) {
        for _ in 0..MOST_CLIMBS {
            let before = self.best_ln;
            for k in 0..self.best.len() {
                let (mut place, mut highest) = (self.best.clone(), f64::NEG_INFINITY);
                for level in 0..self.levels.len() {
                    place[k] = level;
                    let ln = self.visit(&place);
                    highest = highest.max(ln);
                    if ln < highest - HOPELESS {
                        break;
                    }
                }
            }
            if self.best_ln <= before {
                break;
            }
        }
    }

    /// From the best member to neighbours (a step up, a step down, none at all) as long as they weigh something.
    fn spread(&mut self) {
        let mut open = vec![self.best.clone()];
        let mut done = BTreeSet::new();
        while let Some(place) = open.pop() {
            if !done.insert(place.clone()) {
                continue;
            }
            for k in 0..place.len() {
                for level in [place[k].saturating_sub(1), (place[k] + 1).min(self.levels.len() - 1), 0] {
                    let mut next = place.clone();
                    next[k] = level;
                    if self.visit(&next) - self.best_ln > LIGHT.ln() && !done.contains(&next) {
                        open.push(next);
                    }
                }
            }
        }
    }

    fn mean(&self) -> Variances {
        let products = &self.products;
        let mut total = 0.0;
        let mut mean = Variances { white: 0.0, kinds: vec![0.0; products.given], levers: 0.0 };
        for (place, member) in &self.members {
            let weight = (member.ln - self.best_ln).exp();
            let variance = |level: usize| weight * member.white * self.levels[level].theta;
            total += weight;
            mean.white += weight * member.white;
            for (kind, &level) in products.kinds.iter().zip(place) {
                mean.kinds[kind.given] += variance(level);
            }
            mean.levers += place.get(products.kinds.len()).map_or(0.0, |&level| variance(level));
        }
        mean.white /= total;
        mean.kinds.iter_mut().for_each(|variance| *variance /= total);
        mean.levers /= total;
        mean
    }
}
