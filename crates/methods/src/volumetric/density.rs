//! How densely a volume is looked at: what goes on between the places of a grid is in no extreme of it.
//!
//! Along one axis, the others at their lowest or at their highest positions: e at F places, close enough for the shortest wave of the model, has
//! the range r_F, at N of them r_N ≤ r_F. A grid with N places along the axis misses r_F − r_N.
//! Where e is a sum of functions of one axis each, the ranges of the whole volume lack the sum over its axes.
//! Limits: what one axis does where two others stand between their ends is not looked at.

use super::columns::Columns;
use super::volume::{MOST_PLACES, Volume};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use trunnion_core::{AxisValues, Joint};
use trunnion_effects::{Instance, Model};
use trunnion_engine::{Experiment, Identification, IdentifyError};

/// Intervals of a line that is looked at closely, at least: those of 48 waves that no effect of the model states.
const FINE: f64 = 768.0;
/// Places in a wave: the peak of a sine lies no more than 1 − cos(π/16) = 2 % of its amplitude above the highest of them, 1 % of its range.
const IN_A_WAVE: f64 = 16.0;
/// Intervals of a line at most, so that it costs no more than the map.
const MOST_INTERVALS: usize = 12_288;
/// A grid is dense enough when it misses no more of a range than this share, or than its standard uncertainty.
pub const MISSES: f64 = 0.01;
/// Intervals that are tried along an axis; twice as many each time from here on.
const COARSE: [usize; 3] = [2, 3, 6];

/// How densely one axis is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Looked {
    /// The axis.
    pub axis: Joint,
    /// Places along it.
    pub places: usize,
    /// Their distance, mm or rad.
    pub step: f64,
    /// By how much the ranges of e along the axis are larger between them: X, Y, Z, A, B, C, mm and rad.
    pub missed: [f64; 6],
}

/// What a fitted model says along the axes of a volume.
pub struct Lines<'a> {
    experiment: &'a Experiment,
    model: &'a Model,
    fit: &'a Identification,
    volume: &'a Volume,
}

/// e along one axis, and what it is worth.
struct Line {
    /// Rows: X Y Z A B C of each place.
    map: DMatrix<f64>,
    error: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl<'a> Lines<'a> {
    /// Along the axes of a volume.
    pub fn new(
        experiment: &'a Experiment,
        model: &'a Model,
        fit: &'a Identification,
        volume: &'a Volume,
    ) -> Self {
        Self { experiment, model, fit, volume }
    }

    /// How densely the volume is looked at.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn looked(&self) -> Result<Vec<Looked>, IdentifyError> {
        let look = |axis: Joint| {
            let intervals = self.volume.steps[axis] - 1;
            let mut missed = [0.0; 6];
            for line in self.closely(axis, intervals)? {
                missed = std::array::from_fn(|k| f64::max(missed[k], line.missed(k, intervals)));
            }
            let (low, high) = self.volume.range[axis];
            Ok(Looked { axis, places: intervals + 1, step: (high - low) / intervals as f64, missed })
        };
        self.volume.moving().map(look).collect()
    }

    /// The volume with a grid that is dense enough, as far as there may be so many places.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn dense(&self) -> Result<Volume, IdentifyError> {
        let mut needed = AxisValues::from_fn(|_| 0usize);
        for axis in self.volume.moving() {
            let [.., usual] = COARSE;
            let lines = self.closely(axis, usual)?;
            let is_enough = |intervals: &usize| lines.iter().all(|line| line.is_enough(*intervals));
            needed[axis] = candidates().find(is_enough).unwrap_or(MOST_INTERVALS);
        }
        let moving: Vec<Joint> = self.volume.moving().collect();
        let [.., usual] = COARSE;
        let mut intervals = AxisValues::from_fn(|slot| needed[slot].max(usual));
        let too_many = |intervals: &AxisValues<usize>| {
            moving.iter().map(|axis| (intervals[*axis] + 1) as f64).product::<f64>() > MOST_PLACES as f64
        };
        if too_many(&intervals) {
            intervals = needed;
        }
        while too_many(&intervals) {
            let Some(&most) = moving.iter().max_by_key(|axis| intervals[**axis]) else { break };
            intervals[most] /= 2;
        }
        let steps = AxisValues::from_fn(|slot| intervals[slot] + 1);
        Ok(Volume { steps, ..self.volume.clone() })
    }

    /// e along an axis, in a multiple of `intervals`, through two corners of the volume.
    fn closely(&self, axis: Joint, intervals: usize) -> Result<Vec<Line>, IdentifyError> {
        let (low, high) = self.volume.range[axis];
        let waves = self.shortest(axis)?.map_or(0.0, |shortest| IN_A_WAVE * (high - low) / shortest);
        let mut fine = intervals;
        while (fine as f64) < waves.max(FINE) && 2 * fine <= MOST_INTERVALS {
            fine *= 2;
        }
        let through = |corner: fn((f64, f64)) -> f64| {
            let at = |joint: Joint| {
                if joint == axis {
                    (low, high)
                } else {
                    (corner(self.volume.range[joint]), corner(self.volume.range[joint]))
                }
            };
            let range = AxisValues::of(self.volume.joints.iter().copied(), at);
            let mut steps = self.volume.steps;
            steps[axis] = fine + 1;
            self.line(&Volume { range, steps, ..self.volume.clone() })
        };
        let corners: [fn((f64, f64)) -> f64; 2] = [|range| range.0, |range| range.1];
        corners.into_iter().map(through).collect()
    }

    fn line(&self, volume: &Volume) -> Result<Line, IdentifyError> {
        let columns = Columns::new(&self.experiment.scene, self.model, self.fit, volume)?;
        let of_column = columns.parameters.iter().map(|&j| self.fit.solution[j]);
        let solution = DVector::from_iterator(columns.parameters.len(), of_column);
        let covariance =
            self.fit.covariance.select_columns(&columns.parameters).select_rows(&columns.parameters);
        Ok(Line { error: &columns.by_parameter * solution, map: columns.by_parameter, covariance })
    }

    /// The shortest period of the effects of the model along an axis, mm or rad.
    fn shortest(&self, axis: Joint) -> Result<Option<f64>, IdentifyError> {
        let scene = &self.experiment.scene;
        let mut shortest: Option<f64> = None;
        for entry in &self.model.effects {
            let instance = Instance::from_model_effect(entry, &scene.machine)?;
            let Some(wave) = instance.shapes(scene).wave.filter(|wave| wave.joint() == axis) else {
                continue;
            };
            let fitted = self.fit.effects.iter().find(|effect| effect.id == entry.id);
            let number = fitted.and_then(|effect| effect.shape.first().copied());
            let period = number.map(|number| (TAU / wave.number(number)).abs()).filter(|p| *p > 0.0);
            shortest = [shortest, period].into_iter().flatten().reduce(f64::min);
        }
        Ok(shortest)
    }
}

/// Intervals to try, the fewest first.
fn candidates() -> impl Iterator<Item = usize> {
    let doubled = std::iter::successors(Some(12usize), |intervals| Some(2 * intervals));
    COARSE.into_iter().chain(doubled).take_while(|intervals| *intervals <= MOST_INTERVALS)
}

impl Line {
    fn intervals(&self) -> usize {
        self.error.len() / 6 - 1
    }

    /// Places of the lowest and the highest of a component, of so many intervals.
    fn extremes(&self, component: usize, intervals: usize) -> (usize, usize) {
        let every = (self.intervals() / intervals.max(1)).max(1);
        let value = |k: &usize| self.error[6 * k + component];
        let places = || (0..=self.intervals()).step_by(every);
        let by = |a: &usize, b: &usize| value(a).total_cmp(&value(b));
        (places().min_by(by).unwrap_or(0), places().max_by(by).unwrap_or(0))
    }

    fn range(&self, component: usize, (low, high): (usize, usize)) -> f64 {
        self.error[6 * high + component] - self.error[6 * low + component]
    }

    /// By how much the range of a component is larger between the places of so many intervals.
    fn missed(&self, component: usize, intervals: usize) -> f64 {
        let range = |intervals| self.range(component, self.extremes(component, intervals));
        (range(self.intervals()) - range(intervals)).max(0.0)
    }

    fn is_enough(&self, intervals: usize) -> bool {
        let of_line = self.intervals();
        intervals >= of_line
            || (0..6).all(|component| {
                let (low, high) = self.extremes(component, of_line);
                let row = self.map.row(6 * high + component) - self.map.row(6 * low + component);
                let u = (&row * &self.covariance).dot(&row).max(0.0).sqrt();
                self.missed(component, intervals) <= u.max(MISSES * self.range(component, (low, high)))
            })
    }
}
