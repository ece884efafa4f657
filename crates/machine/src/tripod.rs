//! Three parallel legs that carry a platform: the Exechon type of hybrid machine.
//!
//! `B_i = A_i + R(α_i) R(β_i) (0, 0, −q_i)`                                         [S3 eq. 1–3; α about X, β about Y]
//! `O_M = B_i + R(θ_YZ) R(θ_XZ) m_i`,  `O_M1 = O_M2 = O_M3`                         [S3 eq. 4–5]
//! q_i lengths of the legs (commanded), A_i joints on the base, B_i on the platform, m_i from B_i to the platform's origin
//! O_M in platform axes, R(θ_YZ) about X, R(θ_XZ) about Y. Leg i = 1, 2, 3.
//!
//! The joints decide what S3 leaves unsaid: eq. 4–5 alone have eight angles and six equations. Legs 1 and 3 hang on
//! universal joints with one outer axis, the line A₁A₃ along X, and meet the platform in hinges about its Y: `α₁ = α₃ = θ_YZ`.
//! Leg 2 hangs on a ball joint and meets the platform in a hinge about its X: `(B₂ − A₂) · x_platform = 0`
//! (2-UPR-SPR; López-Custodio, Dai, Fu, Jin 2020). Six angles are left, solved by Newton from the pose at zero.
//! Limits: the joints have no clearance and no offsets; a leg passes on only what acts along it.

mod closure;
mod leg;

pub use leg::Leg;

use closure::{Angles, about_x, guess};
use nalgebra::{Isometry3, Point3, Translation3, Unit, Vector3};
use trunnion_core::{AxisValues, Joint, convert};

/// Steps of Newton's method; from the pose at zero four or five do.
const MOST_STEPS: usize = 30;
/// A closure below this is closed, mm.
const CLOSED_MM: f64 = 1e-10;
/// Longest step of an angle, rad.
const LONGEST_STEP_RAD: f64 = 0.3;

/// Three legs between base and platform.
#[derive(Clone, Debug, PartialEq)]
pub struct Tripod {
    machine_from_base: Isometry3<f64>,
    legs: [Leg; 3],
    at_zero: Angles,
    zero_from_machine: Isometry3<f64>,
}

/// Legs that cannot carry a platform.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TripodError {
    /// The first and third leg do not share an outer axis, or no hinge plane.
    #[error("the {what} of legs {first} and {third} differ in {axes}")]
    NotInOnePlane {
        /// Which joints.
        what: &'static str,
        /// Letter of leg 1.
        first: Joint,
        /// Letter of leg 3.
        third: Joint,
        /// What differs.
        axes: &'static str,
    },
    /// No platform pose for some strokes within the travels.
    #[error("the legs cannot meet the platform at {strokes}")]
    Open {
        /// The strokes, mm.
        strokes: String,
    },
}

/// How the platform moves with the strokes, machine axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegMotion {
    /// Unit vector along the leg at zero, times its sense, as [`crate::Axis::positioning_twist`] has it.
    pub(crate) along: Vector3<f64>,
    /// Velocity of the platform's origin for a unit of stroke, mm/mm.
    pub(crate) velocity: Vector3<f64>,
    /// Angular velocity of the platform for a unit of stroke, rad/mm.
    pub(crate) turning_rad_per_mm: Vector3<f64>,
    /// The platform's origin, mm.
    pub(crate) origin_in_machine_mm: Point3<f64>,
}

impl Tripod {
    /// Legs in the order 1, 2, 3 of S3; `travels_mm` their smallest and largest coordinates.
    ///
    /// # Errors
    /// Joints that do not fit the type, or strokes within the travels for which the platform has no pose.
    pub fn new(
        machine_from_base: Isometry3<f64>,
        legs: [Leg; 3],
        travels_mm: [(f64, f64); 3],
    ) -> Result<Self, TripodError> {
        let in_one_plane = |what, joint: fn(&Leg) -> Vector3<f64>| {
            let apart = joint(&legs[0]) - joint(&legs[2]);
            let axes = "y or z; they lie on one line along x";
            (apart.yz().amax() < 1e-9).then_some(()).ok_or(TripodError::NotInOnePlane {
                what,
                first: legs[0].letter,
                third: legs[2].letter,
                axes,
            })
        };
        in_one_plane("base joints", |leg| leg.base_joint_mm)?;
        in_one_plane("platform joints", |leg| leg.platform_joint_mm)?;
        let mut tripod =
            Self { machine_from_base, at_zero: guess(&legs), legs, zero_from_machine: Isometry3::identity() };
        let open = |q: &AxisValues<f64>| TripodError::Open {
            strokes: tripod
                .legs
                .iter()
                .map(|leg| format!("{} {:.3}", leg.letter, q[leg.letter]))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let zero = AxisValues::default();
        let at_zero = tripod.solve(&tripod.lengths_mm(&zero)).ok_or_else(|| open(&zero))?;
        // Corners and middles of the travels.
        for place in 0..27 {
            let mut strokes = AxisValues::default();
            for (k, leg) in tripod.legs.iter().enumerate() {
                let (low, high) = travels_mm[k];
                strokes[leg.letter] = low + (high - low) * 0.5 * f64::from(place / 3i32.pow(k as u32) % 3);
            }
            tripod.solve(&tripod.lengths_mm(&strokes)).ok_or_else(|| open(&strokes))?;
        }
        tripod.at_zero = at_zero;
        tripod.zero_from_machine = tripod.pose(&at_zero, &tripod.lengths_mm(&zero)).inverse();
        Ok(tripod)
    }

    /// The legs 1, 2, 3 of S3.
    pub fn legs(&self) -> &[Leg; 3] {
        &self.legs
    }

    /// Machine axes from the axes of the base in which the joints are given.
    pub fn machine_from_base(&self) -> Isometry3<f64> {
        self.machine_from_base
    }

    /// True for the stroke of a leg.
    pub fn has(&self, letter: Joint) -> bool {
        self.legs.iter().any(|leg| leg.letter == letter)
    }

    /// Pose of the platform against its pose at zero strokes, machine axes; no numbers where the legs cannot meet.
    pub fn displacement(&self, strokes_mm: &AxisValues<f64>) -> Isometry3<f64> {
        let lengths_mm = self.lengths_mm(strokes_mm);
        match self.solve(&lengths_mm) {
            Some(angles) => self.pose(&angles, &lengths_mm) * self.zero_from_machine,
            None => Translation3::new(f64::NAN, f64::NAN, f64::NAN).into(),
        }
    }

    /// Largest distance between the platform's origins that the three legs give, mm [S3 eq. 5]; `None` when they cannot meet.
    pub fn closure_mm(&self, strokes_mm: &AxisValues<f64>) -> Option<f64> {
        let lengths_mm = self.lengths_mm(strokes_mm);
        let origins = closure::origins_mm(&self.legs, &self.solve(&lengths_mm)?, &lengths_mm);
        let apart = |i: usize, j: usize| (origins[i] - origins[j]).norm();
        Some(apart(0, 1).max(apart(1, 2)).max(apart(0, 2)))
    }

    /// Strokes for a pose of the platform against its pose at zero, machine axes. Only poses the joints allow are reached
    /// exactly: the leg lengths follow from the joints' distances.
    pub fn strokes_mm(&self, displacement: &Isometry3<f64>) -> AxisValues<f64> {
        let machine_from_platform = displacement * self.zero_from_machine.inverse();
        let base_from_platform = self.machine_from_base.inverse() * machine_from_platform;
        let mut strokes = AxisValues::default();
        for leg in &self.legs {
            let joint = base_from_platform * Point3::from(leg.platform_joint_mm);
            let length = (joint.coords - leg.base_joint_mm).norm();
            strokes[leg.letter] = (length - leg.length_at_zero_mm) * leg.sense;
        }
        strokes
    }

    /// Unit vector from base joint to platform joint at zero, machine axes.
    pub fn direction_at_zero(&self, letter: Joint) -> Option<Unit<Vector3<f64>>> {
        let k = self.legs.iter().position(|leg| leg.letter == letter)?;
        Some(Unit::new_normalize(self.machine_from_base * self.at_zero.leg(k)))
    }

    /// How the platform moves with one stroke.
    pub fn leg_motion(&self, letter: Joint, strokes_mm: &AxisValues<f64>) -> Option<LegMotion> {
        let k = self.legs.iter().position(|leg| leg.letter == letter)?;
        let along = self.direction_at_zero(letter)?.into_inner() * self.legs[k].sense;
        let lengths_mm = self.lengths_mm(strokes_mm);
        let angles = self.solve(&lengths_mm)?;
        let by_length = closure::by_length(&angles)[k];
        let rates =
            -closure::slope(&self.legs, &angles, &lengths_mm).lu().solve(&by_length)? * self.legs[k].sense;
        let [tilt, turn, beta_1] = [rates[0], rates[1], rates[2]];
        let (axis_tilt, axis_turn) = (Vector3::x(), angles.hinge());
        let turning = axis_tilt * tilt + axis_turn * turn;
        // O_M by leg 1: B₁ swings with α and β₁ (and grows when it is the one that moves), m₁ turns with the platform.
        let arm = angles.platform() * -self.legs[0].platform_joint_mm;
        let leg = angles.leg(0) * lengths_mm[0];
        let growth = if k == 0 { angles.leg(0) * self.legs[0].sense } else { Vector3::zeros() };
        let velocity = growth + (axis_tilt * tilt + axis_turn * beta_1).cross(&leg) + turning.cross(&arm);
        Some(LegMotion {
            along,
            velocity: self.machine_from_base * velocity,
            turning_rad_per_mm: self.machine_from_base * turning,
            origin_in_machine_mm: self.pose(&angles, &lengths_mm) * Point3::origin(),
        })
    }

    fn lengths_mm(&self, strokes_mm: &AxisValues<f64>) -> [f64; 3] {
        std::array::from_fn(|k| {
            let leg = &self.legs[k];
            leg.length_at_zero_mm + leg.sense * strokes_mm[leg.letter]
        })
    }

    /// Newton on the closure, from the pose at zero; in steps of the way when that is far.
    fn solve(&self, lengths_mm: &[f64; 3]) -> Option<Angles> {
        if !lengths_mm.iter().all(|length| *length > 0.0) {
            return None;
        }
        let mut angles = self.at_zero;
        for _ in 0..MOST_STEPS {
            let open = closure::closure(&self.legs, &angles, lengths_mm);
            if open.amax() < CLOSED_MM {
                return Some(angles);
            }
            let step = -closure::slope(&self.legs, &angles, lengths_mm).lu().solve(&open)?;
            let shorten = (LONGEST_STEP_RAD / step.amax()).min(1.0);
            angles = angles.plus(&(step * shorten));
        }
        // Rounding keeps long legs from closing better.
        (closure::closure(&self.legs, &angles, lengths_mm).amax() < 100.0 * CLOSED_MM).then_some(angles)
    }

    /// Machine from platform.
    fn pose(&self, angles: &Angles, lengths_mm: &[f64; 3]) -> Isometry3<f64> {
        let origin = closure::origins_mm(&self.legs, angles, lengths_mm)[0];
        self.machine_from_base * Isometry3::from_parts(Translation3::from(origin), angles.platform())
    }
}

/// Machine from base: the base's origin in the machine, and its tilt about X [S3 eq. 6, R(θ₀)].
pub(crate) fn base_pose(origin_in_machine_mm: Vector3<f64>, tilt_deg: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(origin_in_machine_mm), about_x(convert::rad_from_deg(tilt_deg)))
}
