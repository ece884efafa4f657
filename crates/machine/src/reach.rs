//! Inverse kinematics: axis positions for a place of the tool point, and for a direction of the tool.
//!
//! `q ← q + J⁺ (wanted − found)`, J from the nominal frames of the joints ([`crate::propagation`]). Machines with linear axes in
//! series arrive in one step; legs in parallel [S3 eq. 4–6] in four or five.

use crate::{JointErrors, Machine, Side};
use nalgebra::{DMatrix, DVector, Point3, Unit, Vector3};
use trunnion_core::{AxisValues, Joint, LEVER_MM};

const MOST_STEPS: usize = 60;
/// A place this near is reached, mm.
const REACHED_MM: f64 = 1e-10;
/// A direction this near is reached.
const REACHED_RAD: f64 = 1e-13;
/// What rounding may leave of a long way, mm.
const ROUNDING_MM: f64 = 1e-8;
/// Directions weaker than this share of the strongest cannot be moved in.
const SINGULAR: f64 = 1e-9;
/// Longest step of a rotary axis, rad, and of a linear one, mm.
const LONGEST_RAD: f64 = 0.5;
const LONGEST_MM: f64 = 200.0;

impl Machine {
    /// Positions of the linear axes (or legs) that bring the tool point to `ball_in_table_mm` while the rotary axes of
    /// `position` stay. `None` when the machine cannot reach it with them.
    pub fn follow(
        &self,
        position: &AxisValues<f64>,
        ball_in_table_mm: &Point3<f64>,
    ) -> Option<AxisValues<f64>> {
        let has_letters = Joint::LINEAR.iter().all(|&letter| self.axis(letter).is_some());
        // Axes in addition to X, Y and Z stay; without these, every linear joint moves.
        let moved = if has_letters { Joint::LINEAR.to_vec() } else { self.linear_joints() };
        if moved.len() < Joint::LINEAR.len() {
            return None;
        }
        let mut start = *position;
        for &letter in &moved {
            start[letter] = 0.0;
        }
        self.approach(start, &moved, ball_in_table_mm, None)
    }

    /// Positions of all axes that bring the tool point to `point_in_table_mm` with the tool's axis (its Z) along
    /// `tool_in_table`, nearest to `start`. `None` when it is out of reach or in a singular pose.
    pub fn reach(
        &self,
        start: &AxisValues<f64>,
        point_in_table_mm: &Point3<f64>,
        tool_in_table: &Unit<Vector3<f64>>,
    ) -> Option<AxisValues<f64>> {
        let moved: Vec<Joint> = self.axes().map(|axis| axis.letter).collect();
        self.approach(*start, &moved, point_in_table_mm, Some(tool_in_table))
    }

    /// Tool point, table axes, mm, and direction of the tool's axis.
    pub fn tool_in_table(&self, position: &AxisValues<f64>) -> (Point3<f64>, Unit<Vector3<f64>>) {
        let none = JointErrors::default();
        let table_from_tool =
            self.machine_from_table(position, &none).inverse() * self.machine_from_tool(position, &none);
        (table_from_tool * Point3::origin(), Unit::new_unchecked(table_from_tool * Vector3::z()))
    }

    fn approach(
        &self,
        start: AxisValues<f64>,
        moved: &[Joint],
        point_mm: &Point3<f64>,
        along: Option<&Unit<Vector3<f64>>>,
    ) -> Option<AxisValues<f64>> {
        let mut position = start;
        let mut last_mm = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let (place, direction) = self.tool_in_table(&position);
            let short_mm = point_mm - place;
            let short_rad = along.map_or_else(Vector3::zeros, |along| direction.cross(along));
            // Opposite directions have no cross product either.
            let opposite = along.is_some_and(|along| direction.dot(along) < 0.0);
            if short_mm.norm() < REACHED_MM && short_rad.norm() < REACHED_RAD && !opposite {
                return Some(position);
            }
            let left_mm = short_mm.norm() + LEVER_MM * short_rad.norm();
            if !left_mm.is_finite() {
                return None;
            }
            if left_mm < ROUNDING_MM && left_mm >= last_mm && !opposite {
                return Some(position);
            }
            last_mm = left_mm;
            let wanted = stacked(&short_mm, &(short_rad * LEVER_MM), along.is_some());
            let columns: Vec<DVector<f64>> = moved
                .iter()
                .map(|&letter| {
                    let (velocity, turning) = self.tool_rate(letter, &position, &place, &direction)?;
                    Some(stacked(&velocity, &(turning * LEVER_MM), along.is_some()))
                })
                .collect::<Option<_>>()?;
            let svd = DMatrix::from_columns(&columns).svd(true, true);
            let step = svd.solve(&wanted, SINGULAR * svd.singular_values.amax()).ok()?;
            let longest = moved.iter().zip(step.iter()).map(|(letter, by)| {
                by.abs() / if letter.is_rotary() { LONGEST_RAD } else { self.longest_mm() }
            });
            let shorten = longest.fold(1.0, f64::max).recip();
            for (&letter, by) in moved.iter().zip(step.iter()) {
                position[letter] += by * shorten;
            }
        }
        None
    }

    /// Slides are straight: any way in one step.
    fn longest_mm(&self) -> f64 {
        if self.tripod.is_some() { LONGEST_MM } else { f64::INFINITY }
    }

    /// Velocity of the tool point in the table and turning rate of the tool's axis (across it) for a unit of one axis.
    fn tool_rate(
        &self,
        letter: Joint,
        position: &AxisValues<f64>,
        place_mm: &Point3<f64>,
        direction: &Unit<Vector3<f64>>,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let machine_from_table = self.machine_from_table(position, &JointErrors::default());
        let point_in_machine = machine_from_table * place_mm;
        let frame = self.joint_frame(letter, position)?;
        let unit = self.axis(letter)?.positioning_twist();
        let sign = if self.side(letter)? == Side::Tool { 1.0 } else { -1.0 };
        let into_table = machine_from_table.rotation.inverse();
        let velocity = into_table * (frame.displacement_mm(&point_in_machine, &unit) * sign);
        let turning = into_table * (frame.turned(&unit).rotation_rad * sign);
        Some((velocity, turning - direction.into_inner() * direction.dot(&turning)))
    }
}

fn stacked(place: &Vector3<f64>, direction: &Vector3<f64>, both: bool) -> DVector<f64> {
    let rows = if both { 6 } else { 3 };
    DVector::from_fn(rows, |i, _| if i < 3 { place[i] } else { direction[i - 3] })
}
