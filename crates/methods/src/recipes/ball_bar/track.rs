//! What a ball bar read in each setup, and which measurement of S4 that is: by how the bar lies and what moves, not by name.

use crate::common::{Mounted, Recognised};
use crate::geometry;
use crate::recipes::{Method, MethodError};
use nalgebra::{Point3, Vector2, Vector3};
use trunnion_core::convert::rad_from_deg;
use trunnion_core::statistics::upper_median;
use trunnion_core::{AxisValues, InstrumentKind, Joint, Point, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine, Side};

/// Other axes that move less than this are at rest, mm or rad.
const STILL_MM: f64 = 0.05;
const STILL_RAD: f64 = 1e-4;
/// An axis that turns less than this is only positioned.
const LEAST_TURN_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// Cosine of a bar that lies along a direction.
const ALONG: f64 = 0.999;
/// Fewer readings show no shape.
const LEAST_READINGS: usize = 12;

/// The measurements that were recognised.
pub(super) type Tracks = Recognised<Track>;

/// One setup of one run.
pub(super) struct Track {
    /// Name of the setup, with the run's number in front when there are several runs.
    pub setup: String,
    pub kind: Kind,
    /// The bar's length is known, so that means are places.
    pub calibrated: bool,
    /// Read while the axis moved, not at rest.
    pub on_the_fly: bool,
    /// Where the other rotary axes stood, rad; zero of the axis that turns.
    pub stood_rad: AxisValues<f64>,
    /// Speed of the axis that turns, rad/s; zero where the run does not show it.
    pub feed_rad_per_s: f64,
    pub samples: Vec<Sample>,
}

/// Which measurement.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// The axis turns alone, bar along its u (0) or v (1): C-X, C-Y.
    Across { axis: Axis, k: usize, height_mm: f64 },
    /// The axis turns alone, bar along it: C-Z.
    Along { axis: Axis },
    /// The axis turns and linear axes follow, bar along it: C-XY (ISO 10791-6 BK2 axial).
    Followed { axis: Axis, radius_mm: f64 },
    /// Anything else: BK2 radial and tangential, the cone frustum.
    Path,
}

/// A rotary axis with the letters across (u, v) and along (w) it.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Axis {
    pub letter: Joint,
    pub frame: [Joint; 3],
}

impl Axis {
    /// Its errors: `E`, direction, axis; of the average line with a `0`.
    pub fn symbol(self, direction: Joint, average_line: bool) -> String {
        format!("E{direction}{}{}", if average_line { "0" } else { "" }, self.letter)
    }

    /// True where gravity does not turn about it, the axes that carry it at zero.
    pub fn is_upright(self) -> bool {
        self.frame[2] == Joint::Z
    }

    /// The letters of the rotations about u, v, w.
    pub fn rotations(self) -> [Joint; 3] {
        self.frame.map(|letter| Joint::ROTARY[letter.index()])
    }
}

/// One reading.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    /// Place on the trace: the turn of the axis, or the way around a path, right-handed, rad.
    pub angle_rad: f64,
    /// −1 or +1.
    pub direction: f64,
    /// Tool against table along the positive letter (of a path: along the bar), less the nominal machine, mm.
    pub reading_mm: f64,
    /// Displacement of what the axis carries along the positive letter, mm; of a path the reading.
    pub moved_mm: f64,
    /// Place of the ball across the axis, u and v from its reference point, mm.
    pub across_mm: Vector2<f64>,
    /// What `moved_mm` is of the reading: +1 or −1 (over the cosine of the bar).
    pub moved_per_reading: f64,
    /// From the table's ball to the tool's, in u, v, w of the axis; of a path in table axes, mm.
    pub bar_mm: Vector3<f64>,
    /// Number of the reading among those of all runs.
    pub number: usize,
}

/// Every setup that is a measurement; of `asked` alone when given.
///
/// # Errors
/// No setup that the method can use.
pub(super) fn recognised(method: &Method, runs: &[Run], asked: Option<Joint>) -> Result<Tracks, MethodError> {
    let wanted = asked.map_or("a rotary axis".into(), |letter| format!("axis {letter}"));
    let what = format!("in no setup does a ball bar read {wanted} turning");
    let next =
        "Run a cycle such as config/cycles/s4-c.toml; circles of linear axes are for --method circular.";
    Tracks::of(method, runs, (&what, next), |Mounted { name, run, setup, points, numbers, .. }, _| {
        let seen = Seen::of(&run.machine, setup, points, numbers)?;
        let track = seen.track(name, run.kind == RunKind::OnTheFly)?;
        match asked.is_none_or(|asked| track.kind.axis().is_some_and(|axis| axis.letter == asked)) {
            true => Ok(track),
            false => Err("another axis than the one asked for".into()),
        }
    })
}

impl Kind {
    /// True where the axis turns alone.
    pub fn alone(self) -> bool {
        matches!(self, Self::Across { .. } | Self::Along { .. })
    }

    pub fn axis(self) -> Option<Axis> {
        match self {
            Self::Across { axis, .. } | Self::Along { axis } | Self::Followed { axis, .. } => Some(axis),
            Self::Path => None,
        }
    }
}

/// The readings of a setup and what the nominal machine does at them.
struct Seen<'a> {
    machine: &'a Machine,
    setup: &'a Setup,
    points: &'a [&'a Point],
    numbers: &'a [usize],
    /// Tool ball − table ball, machine axes, unit length.
    bars_in_machine: Vec<Vector3<f64>>,
    /// Tool ball, table axes, mm.
    tool_in_table_mm: Vec<Point3<f64>>,
    bars_in_table: Vec<Vector3<f64>>,
    /// Distance of the balls on the nominal machine.
    lengths_mm: Vec<f64>,
}

impl<'a> Seen<'a> {
    fn of(
        machine: &'a Machine,
        setup: &'a Setup,
        points: &'a [&'a Point],
        numbers: &'a [usize],
    ) -> Result<Self, String> {
        if setup.instrument != InstrumentKind::BallBar {
            return Err(format!("read by {}, not by a ball bar", setup.instrument.with_article()));
        }
        if points.len() < LEAST_READINGS {
            return Err(format!("has {} readings; {LEAST_READINGS} or more show a shape", points.len()));
        }
        let none = JointErrors::default();
        let mut seen = Self {
            machine,
            setup,
            points,
            numbers,
            bars_in_machine: Vec::new(),
            tool_in_table_mm: Vec::new(),
            bars_in_table: Vec::new(),
            lengths_mm: Vec::new(),
        };
        for point in points {
            let machine_from_table = machine.machine_from_table(&point.state.position, &none);
            let tool_in_machine_mm =
                machine.machine_from_tool(&point.state.position, &none) * setup.ball_in_tool_mm;
            let apart_mm = tool_in_machine_mm - machine_from_table * setup.ball_in_table_mm;
            let bar = apart_mm
                .try_normalize(1e-6)
                .ok_or("both balls are in one place; the bar has no direction")?;
            seen.lengths_mm.push(apart_mm.norm());
            seen.bars_in_machine.push(bar);
            seen.bars_in_table.push(machine_from_table.rotation.inverse() * bar);
            seen.tool_in_table_mm.push(machine_from_table.inverse() * tool_in_machine_mm);
        }
        Ok(seen)
    }

    fn track(&self, name: &str, on_the_fly: bool) -> Result<Track, String> {
        let moves = |letter: Joint| span(self.points.iter().map(|p| p.state.position[letter]));
        let still = |letter: &Joint| moves(*letter) <= if letter.is_rotary() { STILL_RAD } else { STILL_MM };
        let (joints, rotary) = (self.machine.joints(), self.machine.rotary_joints());
        let turning: Vec<_> =
            rotary.iter().copied().filter(|&letter| moves(letter) > LEAST_TURN_RAD).collect();
        if rotary.iter().all(still) {
            return Err("only linear axes move".into());
        }
        let others_still = |axis: Joint, among: &[Joint]| among.iter().filter(|l| **l != axis).all(still);
        let lone = match turning[..] {
            [axis] if others_still(axis, &rotary) => Placed::of(self.machine, axis),
            _ => None,
        };
        let (kind, samples) = match &lone {
            Some(placed) => self.of_axis(placed, others_still(placed.axis.letter, &joints)),
            None => (Kind::Path, self.around_path()?),
        };
        let lone = kind.axis().map(|axis| axis.letter);
        let mut stood_rad = AxisValues::default();
        for joint in rotary.into_iter().filter(|joint| Some(*joint) != lone) {
            stood_rad[joint] = self.points[0].state.position[joint];
        }
        let speeds: Vec<f64> =
            self.points.iter().map(|p| lone.map_or(0.0, |joint| p.state.velocity[joint].abs())).collect();
        Ok(Track {
            setup: name.into(),
            kind,
            calibrated: self.setup.calibrated,
            on_the_fly,
            stood_rad,
            feed_rad_per_s: upper_median(&speeds).unwrap_or(0.0),
            samples,
        })
    }

    /// One rotary axis turns; `alone`: nothing else moves.
    fn of_axis(&self, placed: &Placed<'_>, alone: bool) -> (Kind, Vec<Sample>) {
        let axis = placed.axis;
        let bars: Vec<Vector3<f64>> = self
            .points
            .iter()
            .zip(&self.bars_in_machine)
            .map(|(point, bar)| placed.in_frame(&point.state.position, bar))
            .collect();
        let lies = (0..3).find(|&k| bars.iter().all(|bar| bar[k].abs() > ALONG));
        let balls: Vec<Vector3<f64>> =
            self.points.iter().map(|p| placed.ball_in_frame_mm(self.setup, &p.state.position)).collect();
        let kind = match lies {
            Some(2) if alone => Kind::Along { axis },
            Some(k) if alone => Kind::Across { axis, k, height_mm: balls[0].z },
            Some(2) => Kind::Followed { axis, radius_mm: balls[0].xy().norm() },
            _ => Kind::Path,
        };
        let directions = directions(self.points, axis.letter);
        let samples = (0..self.points.len()).map(|i| {
            let deviation_mm = self.deviation_mm(i);
            let per_reading = match (kind, lies) {
                (Kind::Path, _) | (_, None) => 1.0,
                (_, Some(k)) => 1.0 / bars[i][k],
            };
            let is_opposite = kind != Kind::Path && placed.side == Side::Table;
            let moved_per_reading = if is_opposite { -per_reading } else { per_reading };
            let bar = if kind == Kind::Path { self.bars_in_table[i] } else { bars[i] };
            Sample {
                angle_rad: placed.sense * self.points[i].state.position[axis.letter],
                direction: directions[i],
                reading_mm: per_reading * deviation_mm,
                moved_mm: moved_per_reading * deviation_mm,
                moved_per_reading,
                across_mm: balls[i].xy(),
                bar_mm: bar * self.lengths_mm[i],
                number: self.numbers[i],
            }
        });
        (kind, samples.collect())
    }

    /// Several axes at once: the way of the tool's ball around the middle of its path in table axes.
    fn around_path(&self) -> Result<Vec<Sample>, String> {
        let places: Vec<Vector3<f64>> = self.tool_in_table_mm.iter().map(|p| p.coords).collect();
        let plane = geometry::plane(&places).map_err(|_| "the path goes around no middle".to_string())?;
        let right = Vector3::ith(plane.normal.iamin(), 1.0);
        let up = plane.normal.cross(&right).normalize();
        let right = up.cross(&plane.normal);
        let angle = |place: &Vector3<f64>| {
            let from_middle = place - plane.through_mm;
            up.dot(&from_middle).atan2(right.dot(&from_middle))
        };
        let angles: Vec<f64> = places.iter().map(angle).collect();
        let step = |i: usize| {
            let (a, b) = if i + 1 < angles.len() { (i, i + 1) } else { (i - 1, i) };
            (angles[b] - angles[a]).sin()
        };
        let sample = |i: usize| Sample {
            angle_rad: angles[i],
            direction: if step(i) < 0.0 { -1.0 } else { 1.0 },
            reading_mm: self.deviation_mm(i),
            moved_mm: self.deviation_mm(i),
            moved_per_reading: 1.0,
            across_mm: Vector2::zeros(),
            bar_mm: self.bars_in_table[i] * self.lengths_mm[i],
            number: self.numbers[i],
        };
        Ok((0..angles.len()).map(sample).collect())
    }

    fn deviation_mm(&self, i: usize) -> f64 {
        let point = self.points[i];
        point.reading_mm[0] - predict(self.machine, self.setup, &point.state, &Errors::default()).x
    }
}

/// Directions of travel; where a run does not state them they follow from the angles.
fn directions(points: &[&Point], letter: Joint) -> Vec<f64> {
    let angle = |i: usize| points[i].state.position[letter];
    let stated = |i: usize| {
        let stated: f64 = points[i].state.direction[letter];
        let (a, b) = if i + 1 < points.len() { (i, i + 1) } else { (i - 1, i) };
        if stated != 0.0 { stated } else { angle(b) - angle(a) }
    };
    (0..points.len()).map(|i| if stated(i) < 0.0 { -1.0 } else { 1.0 }).collect()
}

/// A rotary axis that lies along a coordinate of its carrier.
struct Placed<'a> {
    machine: &'a Machine,
    axis: Axis,
    side: Side,
    /// Right-handed turn about w for a positive coordinate.
    sense: f64,
}

impl<'a> Placed<'a> {
    fn of(machine: &'a Machine, letter: Joint) -> Option<Self> {
        let joint = machine.axis(letter)?;
        let along = joint.direction.iamax();
        let frame = [(along + 1) % 3, (along + 2) % 3, along].map(|k| Joint::LINEAR[k]);
        let (cosine, side) = (joint.direction[along], machine.side(letter)?);
        let sense = joint.sense * cosine.signum();
        (cosine.abs() > ALONG).then_some(Self { machine, axis: Axis { letter, frame }, side, sense })
    }

    /// A direction in machine axes as u, v, w.
    fn in_frame(&self, position: &AxisValues<f64>, in_machine: &Vector3<f64>) -> Vector3<f64> {
        let frame = self.machine.joint_frame(self.axis.letter, position).expect("the machine has this axis");
        let in_carrier = frame.machine_from_carrier.inverse() * in_machine;
        Vector3::from_fn(|k, _| in_carrier[self.axis.frame[k].index()])
    }

    /// The ball that the axis carries, from its reference point, u, v, w, mm.
    fn ball_in_frame_mm(&self, setup: &Setup, position: &AxisValues<f64>) -> Vector3<f64> {
        let none = JointErrors::default();
        let frame = self.machine.joint_frame(self.axis.letter, position).expect("the machine has this axis");
        let ball_in_machine_mm = match self.side {
            Side::Table => self.machine.machine_from_table(position, &none) * setup.ball_in_table_mm,
            Side::Tool => self.machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm,
        };
        self.in_frame(position, &(ball_in_machine_mm - frame.origin_in_machine_mm))
    }
}

/// Largest minus smallest.
pub(super) fn span(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (high - low).max(0.0)
}

/// True when the angles go around, a grid one step short of it included.
pub(super) fn whole_turn(angles_rad: &[f64]) -> bool {
    let step = span(angles_rad.iter().copied()) / angles_rad.len().max(2) as f64;
    span(angles_rad.iter().copied()) + step > std::f64::consts::TAU - rad_from_deg(18.0)
}
