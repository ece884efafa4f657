//! Volumetric accuracy: what a fitted model says of tool against table all over a volume.
//!
//! e(q) = R_t⁻¹ (Σ_tool d(p) − Σ_table d(p)),  d(p) = R δ + (R ω) × (p − o) at every joint      [S2 eq. 1–4; docs/design/physics.md §2.1, §2.4]
//! p tool point in machine axes, R_t nominal rotation of the table: deviation of tool against table, actual − nominal, in the axes
//! of the table (at zero of the rotary axes those of the machine); orientation likewise from ω. e is linear in the parameters,
//! e = J x, so that u²(e) = J Σ Jᵀ.
//! Volumetric accuracy: the largest range of e in X, Y, Z and of the orientation in A, B, C over the volume [ISO 230-1; S2 §1].
//!
//! The rigid displacement that fits all of e best is removed first ([`Datum::BestFit`]): no measurement between table and tool
//! sees where the workpiece was put, and the figure should not depend on it. A direction that the data do not see is left out of
//! the figure where it moves anything else; then the figure is a lower bound, and the direction is named.
//! The grid is dense enough for the shortest wave of the model where it may have so many places; what it misses is stated (`density`).
//! Limits: at rest, without direction of travel, at the temperature and time of the first point; inside the measured ranges; what
//! the model lacks is not in it. The range of a map grows with its noise: it means something when well above its u.

mod columns;
mod density;
mod rigid;
mod volume;

pub use density::{Looked, MISSES};
pub use volume::{Volume, VolumeError};

use crate::NotTabulated;
use columns::Columns;
use density::Lines;
use nalgebra::{DMatrix, DVector, Point3, RowDVector, Vector3};
use trunnion_core::{AxisValues, Joint, Twist};
use trunnion_effects::Model;
use trunnion_engine::solve::words::in_words;
use trunnion_engine::{Experiment, Identification, IdentifyError};

/// A null direction counts when it moves the map by more than this share of its largest part.
const MOVES: f64 = 1e-2;
/// Deviations of less are rounding, mm and rad: a picometre, as in tables of axis errors.
const ROUNDING: f64 = 1e-9;

/// What the deviations are against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datum {
    /// The rigid displacement that fits the deviations of the whole volume best is removed.
    BestFit,
    /// The coordinate system that the zeros of the model's parameters define.
    Model,
}

/// Deviations over a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumetricMap {
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs the model was fitted to.
    pub runs: Vec<String>,
    /// Where.
    pub volume: Volume,
    /// Against what.
    pub datum: Datum,
    /// Deviations on the grid, the last axis of X Y Z A B C fastest.
    pub points: Vec<MapPoint>,
    /// Largest ranges in X, Y, Z, A, B, C, mm and rad.
    pub ranges: [Extreme; 6],
    /// Longest vector of position, mm; its `low` is where it is.
    pub longest: Extreme,
    /// Directions that the runs do not see and that would move the map, with the parameters of axes in them: with any the figures
    /// are lower bounds.
    pub unseen: Vec<Unseen>,
    /// Axes of the volume that stood still in the runs: what they do is in no figure.
    pub stood_still: Vec<Joint>,
    /// How densely each axis of the volume was looked at.
    pub looked: Vec<Looked>,
    /// Effects that are not in the map, or only partly, and why.
    pub left_out: Vec<NotTabulated>,
}

/// A direction in parameter space that the runs do not see and that moves the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Unseen {
    /// Parameters of axes in it, e.g. `ECZ.P1`.
    pub direction: String,
    /// Components of the deviation that it moves.
    pub moves: Vec<Joint>,
}

/// The deviation at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPoint {
    /// Axis positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Nominal tool point, table axes, mm.
    pub in_table_mm: Point3<f64>,
    /// Deviation of tool against table, table axes.
    pub error: Twist,
    /// Its standard uncertainty by component.
    pub u: Twist,
}

/// An extreme of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Value, mm or rad.
    pub value: f64,
    /// Standard uncertainty of the difference between the two places, mm or rad.
    pub u: f64,
    /// Index of the point with the lowest value.
    pub low: usize,
    /// Index of the point with the highest.
    pub high: usize,
}

impl Extreme {
    /// True where more than rounding makes it: what no effect of the model changes over the volume is not known to be zero.
    pub fn is_known(&self) -> bool {
        self.value.max(self.u) >= ROUNDING
    }
}

impl VolumetricMap {
    /// True when an error that the runs do not see would change the figures.
    pub fn lower_bound(&self) -> bool {
        !self.unseen.is_empty() || !self.stood_still.is_empty()
    }

    /// True where an effect of the model moves a component (X, Y, Z, A, B, C) at some place by more than rounding.
    pub fn moves(&self, component: usize) -> bool {
        let of = |twist: &Twist| match component {
            k @ 0..3 => twist.translation_mm[k].abs(),
            k => twist.rotation_rad[k - 3].abs(),
        };
        self.points.iter().any(|point| of(&point.error).max(of(&point.u)) >= ROUNDING)
    }

    /// True where nothing but rounding moves tool against table.
    pub fn shows_nothing(&self) -> bool {
        self.ranges.iter().all(|range| range.value < ROUNDING)
    }

    /// The map of a model fitted to an experiment.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn new(
        experiment: &Experiment,
        model: &Model,
        fit: &Identification,
        volume: Volume,
        datum: Datum,
    ) -> Result<Self, IdentifyError> {
        let scene = &experiment.scene;
        let columns = Columns::new(scene, model, fit, &volume)?;
        let raw = &columns.by_parameter;
        let map = match datum {
            Datum::BestFit => rigid::removed(raw, &columns.in_table_mm),
            Datum::Model => raw.clone(),
        };
        let solution = DVector::from_iterator(
            columns.parameters.len(),
            columns.parameters.iter().map(|&j| fit.solution[j]),
        );
        let covariance = fit.covariance.select_columns(&columns.parameters).select_rows(&columns.parameters);
        let error = &map * solution;
        let spread = &map * &covariance;
        let u = DVector::from_fn(error.len(), |i, _| spread.row(i).dot(&map.row(i)).max(0.0).sqrt());
        let twist = |values: &DVector<f64>, k: usize| Twist {
            translation_mm: values.fixed_rows::<3>(6 * k).into(),
            rotation_rad: values.fixed_rows::<3>(6 * k + 3).into(),
        };
        let points: Vec<MapPoint> = columns
            .positions
            .iter()
            .zip(&columns.in_table_mm)
            .enumerate()
            .map(|(k, (position, in_table_mm))| MapPoint {
                position: *position,
                in_table_mm: *in_table_mm,
                error: twist(&error, k),
                u: twist(&u, k),
            })
            .collect();
        let u_of = |row: RowDVector<f64>| (&row * &covariance).dot(&row).max(0.0).sqrt();
        let ranges = std::array::from_fn(|component| {
            let value = |k: usize| error[6 * k + component];
            let (low, high) = extremes(points.len(), value);
            let row = map.row(6 * high + component) - map.row(6 * low + component);
            Extreme { value: value(high) - value(low), u: u_of(row), low, high }
        });
        let length_mm = |k: usize| points[k].error.translation_mm.norm();
        let (_, at) = extremes(points.len(), length_mm);
        let along: Vector3<f64> = points[at].error.translation_mm.try_normalize(0.0).unwrap_or_default();
        let row = along.transpose() * map.rows(6 * at, 3);
        let longest = Extreme {
            value: length_mm(at),
            u: u_of(RowDVector::from_iterator(row.len(), row.iter().copied())),
            low: at,
            high: at,
        };
        let looked = Lines::new(experiment, model, fit, &volume).looked()?;
        let stood_still = volume.moving().filter(|&letter| !scene.moves(letter)).collect();
        Ok(Self {
            machine: fit.machine.clone(),
            runs: fit.runs.clone(),
            unseen: unseen(fit, &columns, &map),
            stood_still,
            looked,
            left_out: columns.left_out,
            volume,
            datum,
            points,
            ranges,
            longest,
        })
    }
}

impl Volume {
    /// The same with as many places along each axis as the model needs, so that no extreme lies between them.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn dense(
        &self,
        experiment: &Experiment,
        model: &Model,
        fit: &Identification,
    ) -> Result<Self, IdentifyError> {
        Lines::new(experiment, model, fit, self).dense()
    }
}

/// Indices of the lowest and the highest value.
fn extremes(count: usize, value: impl Fn(usize) -> f64) -> (usize, usize) {
    (0..count).fold((0, 0), |(low, high), k| {
        (if value(k) < value(low) { k } else { low }, if value(k) > value(high) { k } else { high })
    })
}

/// The null directions that move the map, by the parameters of axes in them.
fn unseen(fit: &Identification, columns: &Columns, map: &DMatrix<f64>) -> Vec<Unseen> {
    // Terms: column of the map, place in the direction.
    let moves = |terms: &[(usize, f64)]| -> Vec<Joint> {
        let largest = |column: &DVector<f64>, components: std::ops::Range<usize>| {
            let of_them = |(i, _): &(usize, &f64)| components.contains(&(i % 6));
            column.iter().enumerate().filter(of_them).fold(0.0, |most: f64, (_, v)| most.max(v.abs()))
        };
        let whole = terms.iter().fold(DVector::zeros(map.nrows()), |sum, &(k, c)| sum + map.column(k) * c);
        let part = |components: std::ops::Range<usize>| {
            let parts = terms
                .iter()
                .map(|&(k, c)| largest(&(columns.by_parameter.column(k) * c), components.clone()));
            parts.fold(0.0, f64::max)
        };
        let (shift_mm, turn_rad) = (part(0..3), part(3..6));
        let moved = |letter: &Joint| {
            let part = if letter.is_rotary() { turn_rad } else { shift_mm };
            let component = letter.index();
            part > 0.0 && largest(&whole, component..component + 1) > MOVES * part
        };
        Joint::ALL.into_iter().filter(moved).collect()
    };
    fit.unobservable
        .iter()
        .filter_map(|direction| {
            let column = |j: usize| columns.parameters.iter().position(|&k| k == j);
            let of_axes: Vec<usize> =
                (0..direction.inside.len()).filter(|&i| column(direction.inside[i].0).is_some()).collect();
            let term = |&i: &usize| Some((column(direction.inside[i].0)?, direction.inside[i].1));
            let terms: Vec<(usize, f64)> = of_axes.iter().filter_map(term).collect();
            let names: Vec<(String, f64)> = of_axes.iter().map(|&i| direction.terms[i].clone()).collect();
            let moves = moves(&terms);
            (!moves.is_empty()).then(|| Unseen { direction: in_words(&names), moves })
        })
        .collect()
}
