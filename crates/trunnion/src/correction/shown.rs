//! What readings show of the errors in a correction.

use super::positions::{commanded, position_share};
use crate::prediction::{INDEPENDENT, orthonormal, without_model};
use crate::{Error, Experiment, Fit};
use nalgebra::{DMatrix, DVector, Vector3};
use std::ops::Range;
use trunnion_core::convert::deg_from_rad;
use trunnion_core::{AxisValues, Joint, Setup, State, Twist, statistics};
use trunnion_effects::Instance;
use trunnion_instruments::Projector;
use trunnion_machine::{Machine, Site};
use trunnion_results::sentences::is_setting;
use trunnion_results::{AxisErrors, AxisTable, PositionShare};

/// Share of the readings that a correction has to move at least to be seen: rounding of 10⁻¹² mm is none.
const SEEN_MM: f64 = 1e-9;

/// Readings about the nominal machine and what the correction changes of them, settings projected out of both: fitted to the rows that
/// count, and taken off every row.
pub(crate) struct Shown {
    /// z, mm.
    readings_mm: DVector<f64>,
    /// What z would have in addition about the commanded positions, mm; `None` where these are not known.
    positions_mm: Option<DVector<f64>>,
    /// c, mm.
    errors_mm: DVector<f64>,
    /// What the errors that the control does not get change, projected in the same way, mm.
    others_mm: DVector<f64>,
    /// Δ by point, mm.
    by_point: Vec<Vector3<f64>>,
    /// Rows that count.
    rows: Vec<usize>,
    /// The rows of each point.
    of_points: Vec<Range<usize>>,
    /// Directions that the settings took.
    taken: usize,
}

impl Shown {
    /// `runs` seen with the settings of the model of `fit`, of `all` errors and those in the file; where they are its own, without its outliers.
    ///
    /// # Errors
    /// Settings that cannot be fitted alone.
    pub fn new(fit: &Fit, runs: &Experiment, all: &AxisErrors, errors: &AxisErrors) -> Result<Self, Error> {
        let points = runs.points();
        let machine = points.machine();
        let used = &fit.identification().used;
        let is_own = runs.is_same(fit.experiment());
        let of_points: Vec<Range<usize>> = (0..points.points.len()).map(|i| points.rows_of(i)).collect();
        let counts = |(i, _): &(usize, &Range<usize>)| !is_own || used[*i];
        let rows: Vec<usize> =
            of_points.iter().enumerate().filter(counts).flat_map(|(_, rows)| rows.clone()).collect();
        let mut moved_mm = DVector::zeros(points.rows());
        let mut others_mm = DVector::zeros(points.rows());
        let mut by_point = Vec::with_capacity(points.points.len());
        for (point, of_point) in points.points.iter().zip(&of_points) {
            let setup = &points.setups[point.state.setup];
            let moved = seen_mm(machine, setup, &point.state, errors);
            let others = seen_mm(machine, setup, &point.state, all) - moved;
            for (k, row) in of_point.clone().enumerate() {
                (moved_mm[row], others_mm[row]) = (moved[k], others[k]);
            }
            by_point.push(moved);
        }
        let model = fit.model().entries();
        let settings: Vec<DVector<f64>> = model
            .effects
            .iter()
            .filter(|entry| is_setting(&entry.id))
            .filter_map(|entry| Instance::from_model_effect(entry, machine).ok())
            .flat_map(|instance| {
                let columns = points.columns(&instance, &[]);
                (0..columns.ncols()).map(|j| columns.column(j).into_owned()).collect::<Vec<_>>()
            })
            .collect();
        let settings = match settings.as_slice() {
            [] => DMatrix::zeros(points.rows(), 0),
            settings => DMatrix::from_columns(settings),
        };
        let basis = Basis::new(&settings, &rows);
        let readings_mm = basis.without(without_model(model, points)?);
        let about_commanded = commanded(runs).map(|points| without_model(model, &points)).transpose()?;
        Ok(Self {
            positions_mm: about_commanded.map(|values| basis.without(values) - &readings_mm),
            readings_mm,
            errors_mm: basis.without(moved_mm),
            others_mm: basis.without(others_mm),
            by_point,
            taken: basis.of_rows.ncols(),
            rows,
            of_points,
        })
    }

    /// Rms of the readings plus `share` times what the errors change of them.
    pub fn rms_mm(&self, share: f64) -> f64 {
        self.rms(&(&self.readings_mm + &self.errors_mm * share))
    }

    /// The length of the reading of each point, those that do not count too, likewise.
    pub fn sizes_mm(&self, share: f64) -> Vec<f64> {
        let readings_mm = &self.readings_mm + &self.errors_mm * share;
        self.of_points.iter().map(|rows| readings_mm.rows_range(rows.clone()).norm()).collect()
    }

    fn rms(&self, values: &DVector<f64>) -> f64 {
        statistics::rms(self.rows.iter().map(|row| values[*row])).unwrap_or(0.0)
    }

    /// Rms of what all errors would make of readings without noise.
    pub fn without_mm(&self) -> f64 {
        self.rms(&(&self.errors_mm + &self.others_mm))
    }

    /// True where the readings show the errors at all.
    pub fn is_seen(&self) -> bool {
        self.errors_mm.select_rows(&self.rows).amax() > SEEN_MM
    }

    /// k and its standard uncertainty.
    pub fn share(&self) -> (f64, f64) {
        let (remaining, u) = self.share_of(&(&self.readings_mm - &self.others_mm));
        (1.0 - remaining, u)
    }

    /// The share of the correction that stands in the recorded positions; `None` where the commanded ones are not known.
    pub fn in_positions(&self) -> Option<PositionShare> {
        let (share, u) = self.share_of(self.positions_mm.as_ref()?);
        Some(position_share(-share, u))
    }

    /// The same readings about the commanded positions.
    pub fn about_commanded(mut self) -> Self {
        if let Some(positions_mm) = self.positions_mm.take() {
            self.readings_mm += positions_mm;
        }
        self
    }

    /// How much of the correction is in these values, and its standard uncertainty.
    fn share_of(&self, values: &DVector<f64>) -> (f64, f64) {
        let errors_mm = self.errors_mm.select_rows(&self.rows);
        let size = errors_mm.norm_squared();
        if size <= SEEN_MM * SEEN_MM {
            return (1.0, f64::INFINITY);
        }
        let values = values.select_rows(&self.rows);
        let share = values.dot(&errors_mm) / size;
        let left = values - errors_mm * share;
        let degrees = self.rows.len().saturating_sub(self.taken + 1).max(1);
        let scatter = (left.norm_squared() / degrees as f64).sqrt();
        (share, scatter / size.sqrt())
    }

    /// Two poses of one setup that the errors separate most, the one that they move less first, as numbers of points.
    pub fn farthest_pair(&self, runs: &Experiment) -> Option<[usize; 2]> {
        let points = runs.points();
        let pair = (0..points.setups.len()).filter_map(|setup| {
            let own: Vec<usize> =
                (0..points.points.len()).filter(|&i| points.points[i].state.setup == setup).collect();
            let from = |i: usize| move |&j: &usize| (self.by_point[j] - self.by_point[i]).norm();
            let farthest = |i: usize| own.iter().copied().max_by(|a, b| from(i)(a).total_cmp(&from(i)(b)));
            let first = farthest(*own.first()?)?;
            let second = farthest(first)?;
            Some((first, second, from(first)(&second)))
        });
        let (a, b, apart_mm) = pair.max_by(|one, other| one.2.total_cmp(&other.2))?;
        if apart_mm <= SEEN_MM {
            return None;
        }
        Some(if self.by_point[a].norm() <= self.by_point[b].norm() { [a, b] } else { [b, a] })
    }
}

/// The directions of settings, fitted to some of the rows.
struct Basis {
    /// A W, where A W is orthonormal in the rows that count.
    of_all: DMatrix<f64>,
    /// Its rows that count.
    of_rows: DMatrix<f64>,
    rows: Vec<usize>,
}

impl Basis {
    fn new(columns: &DMatrix<f64>, rows: &[usize]) -> Self {
        let columns_of_rows = columns.select_rows(rows);
        let of_rows = orthonormal(&columns_of_rows);
        let mut of_all = DMatrix::zeros(columns.nrows(), of_rows.ncols());
        if of_rows.ncols() > 0 {
            // A W = Q in these rows, W = A⁺ Q: a direction that they do not show takes nothing off any row.
            let svd = columns_of_rows.svd(true, true);
            let within = INDEPENDENT * svd.singular_values.max();
            if let Ok(weights) = svd.solve(&of_rows, within) {
                of_all = columns * weights;
            }
        }
        Self { of_all, of_rows, rows: rows.into() }
    }

    /// The values without these directions.
    fn without(&self, values: DVector<f64>) -> DVector<f64> {
        let along = self.of_rows.tr_mul(&values.select_rows(&self.rows));
        values - &self.of_all * along
    }
}

/// What the errors change of a reading, mm.
pub(super) fn seen_mm(machine: &Machine, setup: &Setup, state: &State, errors: &AxisErrors) -> Vector3<f64> {
    let projector = Projector::new(machine, setup, state);
    let of_axis = |table: &AxisTable| {
        let letter = machine.joint(&table.axis)?;
        Some(projector.column(Site::Joint(letter), &error_at(table, letter, &state.position)))
    };
    let [x, y, z, a, b, c] = errors.tool;
    let of_tool_mm = Vector3::new(x, y, z) + Vector3::new(a, b, c).cross(&setup.ball_in_tool_mm.coords);
    let of_tool = projector.column(Site::SpindleBall, &Twist::translation(of_tool_mm));
    errors.axes.iter().filter_map(of_axis).sum::<Vector3<f64>>() + of_tool
}

/// Location and component errors of an axis where it stands; beyond the table the nearest row.
fn error_at(table: &AxisTable, letter: Joint, position: &AxisValues<f64>) -> Twist {
    let mut error = table.location;
    if let (Some(&first), Some(&last)) = (table.positions.first(), table.positions.last()) {
        let here = if letter.is_rotary() { deg_from_rad(position[letter]) } else { position[letter] };
        let here = if table.whole_turn { first + (here - first).rem_euclid(last - first) } else { here };
        let here = here.clamp(first, last);
        let above = table.positions.partition_point(|row| *row <= here).clamp(1, table.positions.len() - 1);
        let (low, high) = (table.positions[above - 1], table.positions[above]);
        let share = (here - low) / (high - low);
        for (k, value) in error.iter_mut().enumerate() {
            *value += table.errors[above - 1][k] * (1.0 - share) + table.errors[above][k] * share;
        }
    }
    let [x, y, z, a, b, c] = error;
    Twist { translation_mm: Vector3::new(x, y, z), rotation_rad: Vector3::new(a, b, c) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The committed run, and its readings with 60 µm more along X at one pose.
    fn runs(folder: &std::path::Path) -> [Experiment; 2] {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-nothing-hidden");
        let data = std::path::Path::new(data);
        let text = std::fs::read_to_string(data.join("points.csv")).expect("committed points");
        let head: Vec<&str> = text.lines().next().expect("a head").split(',').collect();
        let dx = head.iter().position(|cell| *cell == "dx_um").expect("readings");
        let with_outlier = |(row, line): (usize, &str)| {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            if row == 41 {
                cells[dx] = (cells[dx].parse::<f64>().expect("a number") + 60.0).to_string();
            }
            cells.join(",")
        };
        let changed: Vec<String> = text.lines().enumerate().map(with_outlier).collect();
        std::fs::write(folder.join("points.csv"), changed.join("\n")).expect("a writable folder");
        std::fs::copy(data.join("setup.toml"), folder.join("setup.toml")).expect("a writable folder");
        [data, folder].map(|of| crate::open(of.join("points.csv")).expect("points"))
    }

    #[test]
    fn outliers_of_the_fitted_run_are_no_outliers_of_another_of_as_many_points() {
        let folder = tempfile::tempdir().expect("a folder");
        let [clean, with_outlier] = runs(folder.path());
        let fit = with_outlier.fit(&with_outlier.base_model()).expect("it can be fitted");
        let excluded = fit.identification().outliers.len();
        assert!(excluded > 0, "the outlier is excluded");
        let all = fit.axis_errors().expect("errors of the axes");
        let rows =
            |runs: &Experiment| Shown::new(&fit, runs, &all, &all).expect("its settings fit").rows.len();
        assert_eq!(rows(&clean), clean.points().rows(), "every reading of the other run");
        let again = crate::open(folder.path().join("points.csv")).expect("points");
        for own in [&with_outlier, &again] {
            assert_eq!(rows(own), own.points().rows() - 3 * excluded, "its own without its outliers");
        }
    }
}
