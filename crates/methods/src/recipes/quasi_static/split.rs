//! Least squares of each error over the sweeps: quasi-static part, and parts with way, speed and acceleration.

use super::noise::u_of_quasi_static;
use super::read::Read;
use super::sweeps::Sweeps;
use crate::common::feed;
use crate::common::of_few::widening;
use crate::common::significance::BY_CHANCE;
use crate::control_chart::t_beyond;
use crate::recipes::{Method, MethodError};
use nalgebra::{DMatrix, DVector};
use trunnion_core::statistics::COVERAGE_95;
use trunnion_cycles::Run;

/// A part of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    QuasiStatic,
    Way,
    Speed,
    Acceleration,
}

impl Part {
    pub const ALL: [Self; 4] = [Self::QuasiStatic, Self::Way, Self::Speed, Self::Acceleration];

    pub fn name(self) -> &'static str {
        match self {
            Self::QuasiStatic => "quasi-static part",
            Self::Way => "part with the direction",
            Self::Speed => "part with speed",
            Self::Acceleration => "part with acceleration",
        }
    }

    pub fn depends_on_feed(self) -> bool {
        matches!(self, Self::Speed | Self::Acceleration)
    }
}

/// What the sweeps separate.
pub(super) struct Parts {
    /// Feed at which the parts with speed and acceleration are given, mm/s or rad/s.
    pub fastest: f64,
    pub both_ways: bool,
    pub separated: Vec<Part>,
    pub degrees_of_freedom: usize,
    /// u of the quasi-static part holds the noise of all readings, not the scatter of the sweeps alone.
    pub noise_is_known: bool,
    /// One for each error: value and u of each separated part, inside units.
    pub of_errors: Vec<Vec<(f64, f64)>>,
}

impl Parts {
    /// How far a part that depends on the feed is from nothing at most, in u.
    pub fn clearest(&self, error: usize) -> f64 {
        let of_feed = self.separated.iter().zip(&self.of_errors[error]);
        of_feed
            .filter(|(part, _)| part.depends_on_feed())
            .map(|(_, (value, u))| value.abs() / u.max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    }

    /// Errors that depend on the feed: of n parts one is beyond t(0.05/n; ν) [Bonferroni], so that where none depends any is named with a probability
    /// of 5 %. u is that of which ± 1.96 u holds 95 %, so it holds t(0.05; ν)/1.96 already.
    pub fn significant(&self) -> Vec<usize> {
        let count =
            self.of_errors.len() * self.separated.iter().filter(|part| part.depends_on_feed()).count();
        let beyond = |share: f64| t_beyond(share, self.degrees_of_freedom);
        let limit = COVERAGE_95 * beyond(BY_CHANCE / count as f64) / beyond(BY_CHANCE);
        (0..self.of_errors.len()).filter(|&error| self.clearest(error) > limit).collect()
    }

    /// The error of a sweep one way at a feed, by its parts.
    pub fn at(&self, error: usize, way: f64, feed: f64) -> f64 {
        let row = row(&self.separated, self.both_ways, way, feed / self.fastest);
        row.iter().zip(&self.of_errors[error]).map(|(factor, (value, _))| factor * value).sum()
    }
}

pub(super) fn parts(method: &Method, runs: &[Run], sweeps: &Sweeps) -> Result<Parts, MethodError> {
    let all = &sweeps.all;
    let fastest = all.iter().map(|sweep| sweep.feed).fold(0.0, f64::max);
    let feeds = feed::feeds(all.iter().map(|sweep| sweep.feed).collect()).len();
    let both_ways = all.iter().any(|sweep| sweep.way > 0.0) && all.iter().any(|sweep| sweep.way < 0.0);
    if feeds < 2 {
        let found = format!("there is one feed in {} sweeps", all.len());
        return Err(method.lacks(
            found,
            "Give a second feed in the cycle file, or runs of the same cycle at another feed.",
        ));
    }
    let separated: Vec<Part> = Part::ALL
        .into_iter()
        .filter(|part| match part {
            Part::QuasiStatic | Part::Speed => true,
            Part::Way => both_ways,
            Part::Acceleration => both_ways || feeds > 2,
        })
        .collect();
    let rows: Vec<f64> =
        all.iter().flat_map(|sweep| row(&separated, both_ways, sweep.way, sweep.feed / fastest)).collect();
    let design = DMatrix::from_row_slice(all.len(), separated.len(), &rows);
    let freedom = all.len().saturating_sub(separated.len());
    if freedom == 0 {
        let found = format!("{} sweeps leave no degree of freedom for {} parts", all.len(), separated.len());
        return Err(method.lacks(
            found,
            "Add a third feed, or run each feed twice: count = 2 in [rounds] of the cycle file.",
        ));
    }
    let Some(cofactor) = (design.transpose() * &design).try_inverse() else {
        return Err(
            method.lacks("the two directions were run at different feeds", "Run every feed both ways.")
        );
    };
    let from_sweeps = &cofactor * design.transpose();
    let read: Option<Vec<&Read>> = all.iter().map(|sweep| sweep.read.as_ref()).collect();
    let of_quasi_static: Vec<f64> = from_sweeps.row(0).iter().copied().collect();
    let under_noise = match read {
        Some(read) => u_of_quasi_static(runs, &read, &design, &of_quasi_static)?,
        None => None,
    };
    let wider = widening(freedom);
    let of_error = |error: usize| {
        let values = DVector::from_iterator(all.len(), all.iter().map(|sweep| sweep.values[error]));
        let solution = &from_sweeps * &values;
        let scatter = ((values - &design * &solution).norm_squared() / freedom as f64).sqrt();
        let of_part = |(k, part): (usize, &Part)| {
            let by_scatter = wider * scatter * cofactor[(k, k)].sqrt();
            let shared = under_noise.as_ref().filter(|_| *part == Part::QuasiStatic);
            (solution[k], shared.map_or(by_scatter, |u| by_scatter.max(u[error])))
        };
        separated.iter().enumerate().map(of_part).collect()
    };
    let of_errors = (0..sweeps.errors.len()).map(of_error).collect();
    let noise_is_known = under_noise.is_some();
    Ok(Parts { fastest, both_ways, degrees_of_freedom: freedom, noise_is_known, of_errors, separated })
}

/// What each part counts in a sweep one way at this share of the fastest feed.
fn row(separated: &[Part], both_ways: bool, way: f64, feed: f64) -> Vec<f64> {
    let factor = |part: &Part| match part {
        Part::QuasiStatic => 1.0,
        Part::Way => way,
        Part::Speed => feed * if both_ways { way } else { 1.0 },
        Part::Acceleration => feed * feed,
    };
    separated.iter().map(factor).collect()
}
