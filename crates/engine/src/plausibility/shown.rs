//! What a display shows of a channel that hardly moves.
//!
//! A display that is coarser than the noise shows one value as long as a channel moves by less than a step, and a good one may: the probe
//! along the axis about which a table turns. Such a value says something only where the base model cannot be brought to rest there by what
//! all readings say together.

use super::fitted::Fitted;
use super::looked::{MOST_POINTS, with_points};
use crate::Experiment;
use std::f64::consts::PI;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};
use trunnion_core::{Point, Setup};
use trunnion_cycles::Run;

/// Readings that differ by less are one value, mm: a thousandth of the finest step that a points file of µm shows.
pub(super) const SAME_MM: f64 = 1e-8;
/// A step is coarse from so many standard deviations of the noise on. With fewer, a channel at rest shows one value in 24 points with a
/// chance of 1 − Φ-tail = 0.68²⁴ = 10⁻⁴ [normal distribution].
const COARSE: f64 = 2.0;
/// Steps that the model leaves of a channel that should have moved: half a one is rounding, the rest what the model does not know.
const LEFT_STEPS: f64 = 2.0;
/// Steps of a display by which readings move that are no accident of it.
pub(super) const ALIVE_STEPS: f64 = 10.0;

/// Sizes of what a display shows, mm.
pub(super) struct Shown {
    /// The smallest difference between two values; infinite where there is one value.
    pub step_mm: f64,
    /// Between the smallest and the largest value of the channel that moves most.
    pub span_mm: f64,
}

impl Shown {
    /// Of the channels of some points of a setup.
    pub fn of<'a>(setup: &Setup, points: impl Iterator<Item = &'a Point> + Clone) -> Self {
        let mut shown = Self { step_mm: f64::INFINITY, span_mm: 0.0 };
        for channel in 0..setup.instrument.components().len() {
            let mut values: Vec<f64> = points.clone().map(|point| point.reading_mm[channel]).collect();
            values.sort_by(f64::total_cmp);
            let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
            shown.step_mm = steps.filter(|step| *step > SAME_MM).fold(shown.step_mm, f64::min);
            let span = values.last().zip(values.first()).map_or(0.0, |(last, first)| last - first);
            shown.span_mm = shown.span_mm.max(span);
        }
        shown
    }

    /// Some channel moves by more than a few steps of the display.
    pub fn is_alive(&self) -> bool {
        self.span_mm >= ALIVE_STEPS * self.step_mm
    }
}

/// Whether good channels of a setup would have shown more than one value in these rows of the run, counted from 1.
pub(super) fn would_move(run: &Run, setup: usize, channels: &[usize], rows: &[usize]) -> bool {
    let Some(left) = Left::of(run, setup, |row, channel| rows.contains(&row) && channels.contains(&channel))
    else {
        return true;
    };
    !left.is_coarse() || left.asked_mm > LEFT_STEPS * left.step_mm
}

/// Whether a setup that is read again shows other digits: its noise is not hidden by the display.
pub(super) fn would_differ(run: &Run, setup: usize) -> bool {
    Left::of(run, setup, |_, _| false).is_none_or(|left| !left.is_coarse())
}

/// Chance that two readings of one channel fall on one step of a display, of noise of so much.
pub(super) fn same_within(step_mm: f64, noise_mm: f64) -> f64 {
    (step_mm / (2.0 * noise_mm * PI.sqrt())).min(1.0)
}

/// What the base model leaves of a run, next to the display of a setup.
struct Left {
    step_mm: f64,
    /// Of the readings that are not asked about, robust.
    scatter_mm: f64,
    /// The most of those that are.
    asked_mm: f64,
}

impl Left {
    /// `is_asked`: of a row of the run, counted from 1, and a channel. `None` where the setup shows one value only, or without a model.
    fn of(run: &Run, setup: usize, is_asked: impl Fn(usize, usize) -> bool) -> Option<Self> {
        let good: Vec<(usize, &Point)> =
            (1..).zip(&run.points).filter(|(_, point)| point.is_good()).collect();
        let every = good.len().div_ceil(MOST_POINTS).max(1);
        let (rows, points): (Vec<usize>, Vec<&Point>) = good.into_iter().step_by(every).unzip();
        let own = points.iter().copied().filter(|point| point.state.setup == setup);
        let step_mm = Shown::of(&run.setups[setup], own).step_mm;
        let experiment = Experiment::of_points(&[with_points(run, points)]).ok()?;
        let model = Fitted::new(&experiment).filter(|_| step_mm.is_finite())?;
        let left_mm = model.left_mm(&experiment.readings_mm());
        let mut asked = vec![false; experiment.rows()];
        for (point, row) in rows.into_iter().enumerate() {
            for (channel, at) in experiment.rows_of(point).enumerate() {
                asked[at] = experiment.points[point].state.setup == setup && is_asked(row, channel);
            }
        }
        let of_row = |point: usize, channel: usize| {
            let row = experiment.rows_of(point).start + channel;
            (!asked[row]).then(|| left_mm[row])
        };
        // Robust, /√2 [Neumann 1941].
        let apart_mm = upper_median(&from_next_mm(&experiment, of_row)).unwrap_or(0.0);
        let scatter_mm = apart_mm / MEDIAN_OF_NORMAL / 2f64.sqrt();
        let of_asked = left_mm.iter().zip(&asked).filter(|(_, asked)| **asked).map(|(left, _)| left.abs());
        Some(Self { step_mm, scatter_mm, asked_mm: of_asked.fold(0.0, f64::max) })
    }

    fn is_coarse(&self) -> bool {
        self.step_mm > COARSE * self.scatter_mm
    }
}

/// What a channel differs from its reading before, without sign, mm; `left_mm` of a point and a channel: none of those that are not asked.
pub(super) fn from_next_mm(
    experiment: &Experiment,
    left_mm: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<f64> {
    let of_next = (1..experiment.points.len()).flat_map(|point| {
        let channels = 0..experiment.rows_of(point - 1).len().min(experiment.rows_of(point).len());
        let from_before = |k: usize| Some((left_mm(point, k)? - left_mm(point - 1, k)?).abs());
        channels.filter_map(from_before).collect::<Vec<_>>()
    });
    of_next.collect()
}
