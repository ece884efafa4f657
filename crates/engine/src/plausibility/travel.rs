//! Does a length read along a line follow the travel of the axes? Asked of lasers before any scale is blamed.
//!
//! The reading of a setup grows with the nominal one: s = n·y/n·n = 1, both less their means. Scales and wavelengths are right to 10⁻³, and a beam that is
//! 8° off reads 1 % short; a share that is farther from 1 is a sign, a unit, a deviation instead of a length or another direction.
//! Positions that are the readings themselves, rounded, follow them better than any axis does, and leave no error.

mod no_deviation;
mod targets;

use super::found::{Implausible, plain};
use super::readings::FEWEST_POINTS;
use crate::Experiment;
use crate::noise::learned::display::nominal_readings_mm;
use nalgebra::{DVector, Matrix3, Unit, Vector3};
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::plain as number;
use trunnion_core::statistics::rms;
use trunnion_core::{InstrumentKind, Point};
use trunnion_cycles::Run;

/// Shares that differ by less are one.
const SAME_WITHIN: f64 = 0.01;
/// Deviations from the target follow its travel by no more than this, also in another unit.
const DEVIATION: f64 = 0.05;
/// Travel that can be told from errors of the axes, mm, root mean square.
const LEAST_TRAVEL_MM: f64 = 1.0;
/// Axes that leave a line by more than this share of the travel go along no line.
const OFF_LINE: f64 = 0.01;
/// What a share says: the factor of the readings, and the mistake.
const MISTAKES: [(f64, &str); 10] = [
    (-1.0, "the sign of the readings, or the direction of the setup, is reversed"),
    (1.0 / 25.4, "the readings are given in inches"),
    (25.4, "the positions are given in inches"),
    (1e3, "the readings are given in µm"),
    (1e6, "the readings are given in nm"),
    (1e-3, "the readings are given in metres"),
    (-1e3, "the readings are given in µm, and with the other sign"),
    (-1e-3, "the readings are given in metres, and with the other sign"),
    (-1.0 / 25.4, "the readings are given in inches, and with the other sign"),
    (0.5, "the beam goes to and fro once, and the readings are half of what it says"),
];

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let of_run = |run: &Run| (0..run.setups.len()).find_map(|setup| Line::of(run, setup)?.implausible());
    runs.iter().filter_map(of_run).collect()
}

/// What one setup of a run reads along its line. All less their means, mm.
struct Line<'a> {
    run: &'a Run,
    name: &'a str,
    direction: Vector3<f64>,
    readings_mm: DVector<f64>,
    nominal_mm: DVector<f64>,
    /// The same with the direction along X, Y and Z.
    along_axes_mm: [DVector<f64>; 3],
}

impl<'a> Line<'a> {
    /// `None` where no length is read along a line, or too few points are.
    fn of(run: &'a Run, setup: usize) -> Option<Self> {
        let placed = &run.setups[setup];
        let direction = placed.direction.filter(|_| placed.instrument == InstrumentKind::Diagonal)?;
        let own: Vec<Point> = run.good_points().filter(|point| point.state.setup == setup).cloned().collect();
        if own.len() < FEWEST_POINTS {
            return None;
        }
        let with = |direction: Unit<Vector3<f64>>| {
            let mut turned = Run { points: own.clone(), ..run.clone() };
            turned.setups[setup].direction = Some(direction);
            Experiment::of_points(&[turned]).ok()
        };
        let as_it_is = with(direction)?;
        let along = |axis: Unit<Vector3<f64>>| Some(centred(nominal_readings_mm(&with(axis)?)));
        let along_axes_mm = [along(Vector3::x_axis())?, along(Vector3::y_axis())?, along(Vector3::z_axis())?];
        Some(Self {
            run,
            name: &placed.name,
            direction: direction.into_inner(),
            readings_mm: centred(as_it_is.readings_mm()),
            nominal_mm: centred(nominal_readings_mm(&as_it_is)),
            along_axes_mm,
        })
    }

    fn implausible(&self) -> Option<Implausible> {
        if let Some(travel) = self.travel()
            && travel.dot(&self.direction) < 1.0 - SAME_WITHIN
        {
            return Some(self.elsewhere(&travel));
        }
        let size_mm = rms(self.nominal_mm.iter().copied())?;
        if size_mm < LEAST_TRAVEL_MM {
            return None;
        }
        let share = self.nominal_mm.dot(&self.readings_mm) / self.nominal_mm.norm_squared();
        let is = |factor: f64| (share / factor - 1.0).abs() < SAME_WITHIN;
        if is(1.0) {
            return self.no_deviation().or_else(|| self.no_targets());
        }
        Some({
            let finding = format!(
                "{}: along the direction of setup {} the axes travel {:.1} mm rms, and the readings follow {} times as far.",
                self.run.name,
                self.name,
                size_mm,
                number(share)
            );
            match MISTAKES.into_iter().find(|(factor, _)| is(*factor)) {
                Some((factor, mistake)) => {
                    let left_um = um_from_mm(
                        rms((&self.readings_mm / factor - &self.nominal_mm).iter().copied()).unwrap_or(0.0),
                    );
                    let hypothesis = format!("If {mistake}, {left_um:.1} µm rms are left. Change it?");
                    Implausible { rms_um_with_it: Some(left_um), ..plain(finding, &hypothesis) }
                }
                None if share.abs() < DEVIATION => plain(
                    finding,
                    "The readings hold deviations from the target, not lengths: add the position of the axis to them, or export lengths. Or the \
                     beam was along another axis.",
                ),
                None => plain(
                    finding,
                    "Check the unit and the direction of the setup, and that every reading stands in the row of its position: no single mistake \
                     of unit or sign explains it.",
                ),
            }
        })
    }

    /// Unit vector along which the axes go, to the side of the direction of the setup; `None` where they hardly move or go along no line.
    fn travel(&self) -> Option<Vector3<f64>> {
        let squares = Matrix3::from_fn(|i, j| self.along_axes_mm[i].dot(&self.along_axes_mm[j]));
        let eigen = (squares / self.readings_mm.len() as f64).symmetric_eigen();
        let (most, value) = eigen.eigenvalues.argmax();
        let off: f64 = eigen.eigenvalues.sum() - value;
        let is_line = value > LEAST_TRAVEL_MM.powi(2) && off.max(0.0) < OFF_LINE.powi(2) * value;
        let travel = eigen.eigenvectors.column(most).into_owned();
        is_line.then(|| if travel.dot(&self.direction) < 0.0 { -travel } else { travel })
    }

    fn elsewhere(&self, travel: &Vector3<f64>) -> Implausible {
        let shown = |v: &Vector3<f64>| {
            v.map(|x| if x.abs() < SAME_WITHIN { "0".into() } else { format!("{x:.3}") })
                .iter()
                .cloned()
                .collect::<Vec<String>>()
                .join(", ")
        };
        plain(
            format!(
                "{}: the axes move along [{}] while setup {} is read, and its direction is [{}].",
                self.run.name,
                shown(travel),
                self.name,
                shown(&self.direction)
            ),
            "Correct the direction of the setup (its sign is that in which the reading grows), or the readings are those of another setup.",
        )
    }
}

fn centred(mut values: DVector<f64>) -> DVector<f64> {
    let mean = values.mean();
    values.add_scalar_mut(-mean);
    values
}
