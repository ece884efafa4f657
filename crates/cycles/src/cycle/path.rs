//! Lines and curves that the tool travels: body diagonals, circles, the cone-frustum path.
//!
//! ```toml
//! [line]                              # kind = "static", instead of [[grid]]; from the ball of each setup along its direction
//! length_mm = 600
//! steps = 20
//! in_turn = false                     # true: X, Y and Z step one after the other
//!
//! [circle]                            # kind = "on-the-fly", instead of [sweep]; about the table's ball
//! plane = "XY"
//! radius_mm = 1                       # may be left out: the length of the bar
//! from_deg = -180
//! to_deg = 540
//! feeds_mm_per_min = [1000]
//!
//! [cone]                              # the same, five axes at once; of a machined surface about its centre, circle by circle through its targets
//! half_angle_deg = 15                 # of the cone
//! tilt_deg = 10                       # of its axis against the table's Z, towards X
//! from_deg = 0
//! to_deg = 360
//! feeds_mm_per_min = [1000]
//! ```

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use std::f64::consts::TAU;
use trunnion_core::{AxisValues, Joint, Setup};
use trunnion_machine::{JointErrors, Machine};

/// Rounding of an angle of a target.
const ROUNDING_RAD: f64 = 1e-9;
/// Targets whose circles have their centres nearer are on one: files hold places to some nanometres.
const ONE_CIRCLE_MM: f64 = 1e-3;

/// A straight line from the place of each setup along its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Length, mm.
    pub length_mm: f64,
    /// Number of steps between them.
    pub steps: usize,
    /// True: in every step X, Y and Z move one after the other, with a stop after each [S2 §3.2].
    pub in_turn: bool,
}

/// A curve of the tool about the table's ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// Circle of two linear axes [ISO 230-4].
    Circle {
        /// The axes; the angle runs from the first to the second.
        plane: [Joint; 2],
        /// Radius, mm; `None`: the length of the bar.
        radius_mm: Option<f64>,
    },
    /// Base circle of a cone whose generatrix the tool axis keeps parallel to [NAS 979; ISO 10791-6 BK4].
    Cone {
        /// Angle between the cone's axis and its generatrix, rad.
        half_angle_rad: f64,
        /// Tilt of the cone's axis against the table's Z, towards its X, rad.
        tilt_rad: f64,
    },
}

impl Line {
    /// The places of the spindle-side ball in order, machine axes from the first one, mm.
    pub(super) fn places_mm(&self, direction: &Unit<Vector3<f64>>) -> Vec<Vector3<f64>> {
        let whole = direction.into_inner() * self.length_mm;
        let at = |[x, y, z]: [usize; 3]| {
            let share = |k: usize| k as f64 / self.steps.max(1) as f64;
            whole.component_mul(&Vector3::new(share(x), share(y), share(z)))
        };
        let mut places = vec![at([0; 3])];
        for k in 0..self.steps {
            if self.in_turn {
                places.extend([at([k + 1, k, k]), at([k + 1, k + 1, k])]);
            }
            places.push(at([k + 1; 3]));
        }
        places
    }
}

impl Path {
    /// Radius of the curve in a setup, mm: its own, the length of the bar, or that of the first circle of targets.
    pub(super) fn radius_mm(&self, setup: &Setup) -> f64 {
        let own = match self {
            Self::Circle { radius_mm, .. } => *radius_mm,
            Self::Cone { .. } => None,
        };
        own.or(setup.bar_length_mm).unwrap_or_else(|| match setup.artefact {
            Some(_) => self.circle_of(setup, 0).1,
            None => 1.0,
        })
    }

    /// Centre, table axes, and radius of the circle through a target about the axis of the curve, mm; without targets those of the setup.
    fn circle_of(&self, setup: &Setup, target: usize) -> (Point3<f64>, f64) {
        let centre = setup.ball_in_table_mm;
        if setup.artefact.is_none() {
            return (centre, self.radius_mm(setup));
        }
        let axis = match self {
            Self::Circle { plane: [first, second], .. } => {
                Vector3::ith(first.index(), 1.0).cross(&Vector3::ith(second.index(), 1.0))
            }
            Self::Cone { tilt_rad, .. } => tilted(*tilt_rad) * Vector3::z(),
        };
        let apart = setup.target_in_table_mm(target) - centre;
        let up = axis * apart.dot(&axis);
        (centre + up, (apart - up).norm())
    }

    /// Targets of a setup on the way from one angle to another, circle by circle in the order of the file: the number of the circle, the way on it,
    /// rad, and the index of the target.
    pub(super) fn targets_between(
        &self,
        machine: &Machine,
        setup: &Setup,
        first: f64,
        last: f64,
    ) -> Vec<(usize, f64, usize)> {
        let mut centres: Vec<Point3<f64>> = Vec::new();
        let mut all: Vec<(usize, f64, usize)> = Vec::new();
        for target in 0..setup.targets() {
            let (centre, _) = self.circle_of(setup, target);
            let known = centres.iter().position(|other| (other - centre).norm() < ONE_CIRCLE_MM);
            let circle = known.unwrap_or_else(|| {
                centres.push(centre);
                centres.len() - 1
            });
            let angle = self.angle_rad(machine, setup, &setup.target_in_table_mm(target));
            let way = ((angle - first) * (last - first).signum()).rem_euclid(TAU);
            // At the beginning itself but for rounding.
            let way = if TAU - way < ROUNDING_RAD { 0.0 } else { way };
            if way < (last - first).abs() {
                all.push((circle, way, target));
            }
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        all
    }

    /// Axes that it needs.
    pub(super) fn axes(&self) -> Vec<Joint> {
        match self {
            Self::Circle { plane, .. } => plane.to_vec(),
            Self::Cone { .. } => Joint::LINEAR.to_vec(),
        }
    }

    /// Angle on the curve nearest to a place of the tool point in table axes, −π…π.
    pub(super) fn angle_rad(&self, machine: &Machine, setup: &Setup, place_in_table_mm: &Point3<f64>) -> f64 {
        let [right, up] = match self {
            Self::Circle { plane, .. } => {
                let table = machine.machine_from_table(&AxisValues::default(), &JointErrors::default());
                plane.map(|letter| table.rotation.inverse() * Vector3::ith(letter.index(), 1.0))
            }
            Self::Cone { tilt_rad, .. } => {
                let tilted = tilted(*tilt_rad);
                [tilted * Vector3::x(), tilted * Vector3::y()]
            }
        };
        let apart = place_in_table_mm - setup.ball_in_table_mm;
        apart.dot(&up).atan2(apart.dot(&right))
    }

    /// All axes at `angle_rad` of the curve through a target. `near`: where the rotary axes stood before. `None` when the machine cannot get
    /// there.
    pub(super) fn position(
        &self,
        machine: &Machine,
        (setup, target): (&Setup, usize),
        angle_rad: f64,
        near: &AxisValues<f64>,
    ) -> Option<AxisValues<f64>> {
        let (centre, radius_mm) = self.circle_of(setup, target);
        let (sin, cos) = angle_rad.sin_cos();
        match self {
            Self::Circle { plane, .. } => {
                let along = |letter: Joint| Vector3::ith(letter.index(), radius_mm);
                let apart_mm = along(plane[0]) * cos + along(plane[1]) * sin;
                let rotary = AxisValues::default();
                let table = machine.machine_from_table(&rotary, &JointErrors::default()).rotation;
                let place = centre + table.inverse() * apart_mm;
                reach(machine, setup, &rotary, &place)
            }
            Self::Cone { half_angle_rad, tilt_rad } => {
                let tilted = tilted(*tilt_rad);
                let outward = tilted * Vector3::new(cos, sin, 0.0);
                let up = tilted * Vector3::z();
                // From the base upward and inward.
                let generatrix = up * half_angle_rad.cos() - outward * half_angle_rad.sin();
                let place = centre + outward * radius_mm;
                let posed = pointing(machine, near, &place, &Unit::new_normalize(generatrix))?;
                reach(machine, setup, &posed, &place)
            }
        }
    }
}

/// Table axes from those of a cone that is tilted towards X.
fn tilted(tilt_rad: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), tilt_rad)
}

/// Turns added to the rotary axes, rad: where one has no say (a pole), the way there has no beginning.
const STARTS_RAD: [f64; 5] = [0.0, 0.4, 1.5, -0.4, 2.9];

/// All axes with the tool point at `place` and the tool's axis along `direction`, table axes.
fn pointing(
    machine: &Machine,
    near: &AxisValues<f64>,
    place_in_table_mm: &Point3<f64>,
    direction: &Unit<Vector3<f64>>,
) -> Option<AxisValues<f64>> {
    (0..STARTS_RAD.len()).find_map(|k| {
        let mut start = *near;
        for (i, axis) in machine.rotary().iter().enumerate() {
            start[axis.letter] += if k == 0 { 0.0 } else { STARTS_RAD[(k + i) % STARTS_RAD.len()] };
        }
        machine.reach(&start, place_in_table_mm, direction)
    })
}

/// All axes with the spindle-side ball of `setup` at a place of the table, the rotary axes at `rotary`.
pub(super) fn reach(
    machine: &Machine,
    setup: &Setup,
    rotary: &AxisValues<f64>,
    place_in_table_mm: &Point3<f64>,
) -> Option<AxisValues<f64>> {
    let none = JointErrors::default();
    let table_from_tool = machine.machine_from_table(rotary, &none).rotation.inverse()
        * machine.machine_from_tool(rotary, &none).rotation;
    machine.follow(rotary, &(place_in_table_mm - table_from_tool * setup.ball_in_tool_mm.coords))
}
