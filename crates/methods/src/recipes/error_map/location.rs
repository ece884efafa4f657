//! Location errors of both axes as constants of the map of the tilting axis.
//!
//! A constant error (δ, ω) of the turning axis at its joint looks, over the tilts, like the error of the tilting axis
//! `R_Bᵀ [R_C δ + (R_C ω) × (o_B − o_C)], R_Bᵀ R_C ω`: that is how S1 reads a shift of C's line off its Fig. 6. All constants that the
//! joint fit can see are fitted to the map together, with the two offsets of the zero pose (along and about the turning
//! axis) that no reading sees.

use super::b_errors::BErrors;
use super::grid::Grid;
use crate::common::shares::{Shares, u_under_noise};
use crate::recipes::MethodError;
use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_core::{Joint, LEVER_MM, Twist};
use trunnion_effects::Unit;
use trunnion_effects::catalogue::LOCATION_ERRORS;
use trunnion_engine::solve::linear::least_squares;
use trunnion_engine::{BeyondModel, FittedParameter, Identification, Problem};
use trunnion_machine::propagation::JointFrame;

/// Location errors by maps and by the joint fit.
pub(super) struct Locations {
    pub rows: Vec<Location>,
    /// What the offsets of the zero pose add to the map at each tilt.
    pub datum: Vec<Twist>,
    /// What the location errors make of the map at each tilt.
    pub constants: Vec<Twist>,
}

/// One location error, inside units.
pub(super) struct Location {
    pub name: String,
    pub unit: Unit,
    pub by_map: f64,
    /// Standard uncertainty under the noise that all readings show; where they show none by how far the map is from constants.
    pub u_by_map: f64,
    /// What each reading counts in the value by the map.
    pub shares: Shares,
    pub by_joint_fit: f64,
    pub u_by_joint_fit: Option<f64>,
}

impl Locations {
    pub fn of(grid: &Grid<'_>, b_errors: &BErrors, joint: &Identification) -> Self {
        let observable: Vec<(&FittedParameter, Joint, Twist)> = joint
            .parameters
            .iter()
            .filter(|p| p.effect == LOCATION_ERRORS && p.observable())
            .filter_map(|p| {
                let axes = [grid.tilting, grid.turning];
                constant(&p.name, axes).map(|(axis, twist)| (p, axis, twist))
            })
            .collect();
        let along = Vector3::ith(grid.turning.index() % 3, 1.0);
        let offsets = [Twist::translation(along), Twist::rotation(along)].map(|twist| (grid.turning, twist));
        let constants: Vec<(Joint, Twist)> =
            observable.iter().map(|(_, axis, twist)| (*axis, *twist)).chain(offsets).collect();
        let frames: Vec<(JointFrame, JointFrame)> = (0..grid.tilts_rad.len())
            .filter_map(|tilt| grid.at_tilt(tilt).next().map(|(.., cell)| (cell.tilting, cell.turning)))
            .collect();
        let seen = |(axis, twist): &(Joint, Twist), frames: &(JointFrame, JointFrame)| {
            if *axis == grid.tilting { *twist } else { as_tilting(frames, twist) }
        };
        let rows = 6 * frames.len();
        let mut a = DMatrix::zeros(rows, constants.len());
        let mut b = DVector::zeros(rows);
        for (i, (of_tilt, twist)) in frames.iter().zip(&b_errors.at_tilt).enumerate() {
            b.fixed_rows_mut::<6>(6 * i).copy_from(&stacked(twist));
            for (k, constant) in constants.iter().enumerate() {
                a.fixed_view_mut::<6, 1>(6 * i, k).copy_from(&stacked(&seen(constant, of_tilt)));
            }
        }
        let fit = least_squares(&a, &b, 1e-7);
        // Of every constant: of the map, then of the cells.
        let from_cells = &fit.cofactor * a.transpose() * stacked_from_cells(b_errors);
        let cells: Vec<(f64, &Shares)> = (0..grid.tilts_rad.len())
            .flat_map(|tilt| grid.at_tilt(tilt))
            .flat_map(|(.., cell)| cell.shares_of_sum.iter().map(|sum| ((cell.readings as f64).recip(), sum)))
            .collect();
        let shares = |k: usize| {
            let of_cells = from_cells.row(k);
            Shares::sum(of_cells.iter().zip(&cells).map(|(factor, (mean, sum))| (factor * mean, *sum)))
        };
        let found = |(k, (parameter, ..)): (usize, &(&FittedParameter, Joint, Twist))| Location {
            name: parameter.name.clone(),
            unit: parameter.unit,
            by_map: fit.x[k],
            u_by_map: fit.u[k],
            shares: shares(k),
            by_joint_fit: parameter.value.unwrap_or_default(),
            u_by_joint_fit: parameter.u,
        };
        let first = observable.len();
        let part = |of: std::ops::Range<usize>| {
            let at = |frames| {
                of.clone()
                    .map(|k| seen(&constants[k], frames) * fit.x[k])
                    .fold(Twist::default(), |a, b| a + b)
            };
            frames.iter().map(at).collect()
        };
        Self {
            rows: observable.iter().enumerate().map(found).collect(),
            datum: part(first..constants.len()),
            constants: part(0..first),
        }
    }

    /// With u under the noise that all readings show together, where they say what is noise. What varies over the map is a part of it: constants do
    /// not describe it.
    pub fn under_noise(mut self, problem: &Problem<'_>) -> Result<Self, MethodError> {
        let shares: Vec<&Shares> = self.rows.iter().map(|row| &row.shares).collect();
        if let Some(u) = u_under_noise(problem, &shares, BeyondModel::NOTHING)? {
            self.rows.iter_mut().zip(u).for_each(|(row, u)| row.u_by_map = u);
        }
        Ok(self)
    }
}

/// The map, stacked as it is fitted, from the means of the cells.
fn stacked_from_cells(b_errors: &BErrors) -> DMatrix<f64> {
    let from_cells = &b_errors.cofactor * b_errors.design.transpose();
    let mut stacked = DMatrix::zeros(6 * b_errors.of_tilt.len(), from_cells.ncols());
    for (tilt, &first) in b_errors.of_tilt.iter().enumerate() {
        for k in 0..6 {
            let lever = if k < 3 { 1.0 } else { LEVER_MM };
            stacked.row_mut(6 * tilt + k).copy_from(&(from_cells.row(first + k) * lever));
        }
    }
    stacked
}

/// Axis and unit twist of a location error of one of these axes by its name, `EX0C`.
fn constant(name: &str, axes: [Joint; 2]) -> Option<(Joint, Twist)> {
    let of_axes = axes.into_iter().flat_map(|axis| Joint::ALL.map(|direction| (axis, direction)));
    let (axis, direction) =
        of_axes.into_iter().find(|(axis, direction)| format!("E{direction}0{axis}") == name)?;
    let unit = Vector3::ith(direction.index() % 3, 1.0);
    let twist = if direction.is_rotary() { Twist::rotation(unit) } else { Twist::translation(unit) };
    Some((axis, twist))
}

/// An error at the joint of the turning axis as one at the joint of the tilting axis.
fn as_tilting((tilting, turning): &(JointFrame, JointFrame), twist: &Twist) -> Twist {
    let omega = turning.machine_from_carrier * twist.rotation_rad;
    let between = tilting.origin_in_machine_mm - turning.origin_in_machine_mm;
    let delta = turning.machine_from_carrier * twist.translation_mm + omega.cross(&between);
    let carrier_from_machine = tilting.machine_from_carrier.inverse();
    Twist { translation_mm: carrier_from_machine * delta, rotation_rad: carrier_from_machine * omega }
}

fn stacked(twist: &Twist) -> nalgebra::Vector6<f64> {
    let (delta, omega) = (twist.translation_mm, twist.rotation_rad * LEVER_MM);
    nalgebra::Vector6::new(delta.x, delta.y, delta.z, omega.x, omega.y, omega.z)
}
