//! What a picture shows: the example of an effect seen in its view on machine table-bc.

use crate::catalogue::BASE;
use crate::{Effect, Example, Instance, Scene, SceneSetup, View, r_test_reading};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use std::f64::consts::{PI, TAU};
use trunnion_core::number::trimmed;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_machine::{Machine, shipped};

/// A picture before it is drawn; values in µm.
pub(super) struct Drawing {
    /// What is drawn, and what it is of.
    pub caption: [String; 2],
    pub plot: Plot,
}

pub(super) enum Plot {
    /// x, y, z over C (columns) and B (rows), degrees.
    Maps {
        b_deg: Vec<f64>,
        c_deg: Vec<f64>,
        xyz_um: [Vec<f64>; 3],
    },
    Curves {
        x_label: &'static str,
        y_label: &'static str,
        series: Vec<Series>,
    },
    /// Radius over the angle of a circle.
    Polar {
        traces: Vec<Series>,
    },
}

pub(super) struct Series {
    pub name: String,
    pub colour: &'static str,
    pub dashed: bool,
    pub points: Vec<(f64, f64)>,
}

const XYZ: [(&str, &str); 3] = [("x", "#c1272d"), ("y", "#2a7f3f"), ("z", "#1f5fa8")];
const GREY: &str = "#666";
const RADIUS_MM: f64 = 150.0;

pub(super) fn drawing(effect: &Effect) -> Drawing {
    let machine = shipped::machine("table-bc").expect("shipped machines parse (tested)");
    let example = &effect.example;
    match example.view {
        View::Poses => poses(machine, example),
        View::Turn => turn(machine, example),
        View::Circle(feeds) => circles(machine, example, feeds),
        View::Time(span_s) => over_time(machine, example, span_s),
        View::StopAndGo => stop_and_go(machine, example),
        View::Deflection => deflection(machine, example),
    }
}

/// An effect with its parameters in the scene of a picture.
struct Placed<'a> {
    scene: Scene,
    instance: Instance,
    shape: &'a [f64],
    /// Inside units.
    values: Vec<f64>,
}

impl<'a> Placed<'a> {
    fn new(machine: Machine, example: &'a Example, setups: Vec<SceneSetup>, states: &[State]) -> Self {
        let instance =
            Instance::find(example.id, &machine).expect("examples are effects of table-bc (tested)");
        let scene = Scene::new(machine, setups, vec!["frame".into()], states.iter());
        let parameters = instance.parameters(&scene);
        let value = |name: &str| example.values.iter().find(|(known, _)| *known == name).map_or(0.0, |v| v.1);
        let values = parameters.iter().map(|p| value(&p.name) / p.unit.per_inside).collect();
        Self { scene, instance, shape: example.shape, values }
    }

    /// Error of the reading, mm.
    fn reading_mm(&self, state: &State) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        r_test_reading(
            &self.instance,
            &self.scene,
            self.shape,
            state,
            Point3::origin(),
            &mut |i, reading| sum += reading * self.values[i],
        );
        sum
    }

    /// Readings of all states without what location errors and ball setting can take, µm; the share that is left.
    fn left_um(&self, states: &[State]) -> (Vec<Vector3<f64>>, f64) {
        let readings = states.iter().flat_map(|s| Vec::from(<[f64; 3]>::from(self.reading_mm(s))));
        let all = DVector::from_iterator(3 * states.len(), readings);
        let id = self.instance.id();
        let left =
            if BASE.contains(&id.as_str()) { all.clone() } else { &all - self.base_part(states, &all) };
        let share = left.norm() / all.norm().max(f64::MIN_POSITIVE);
        (left.as_slice().chunks(3).map(|r| Vector3::from_column_slice(r) * 1e3).collect(), share)
    }

    fn base_part(&self, states: &[State], all: &DVector<f64>) -> DVector<f64> {
        let base = BASE
            .map(|id| Instance::find(id, &self.scene.machine).expect("base effects are for all machines"));
        let widths = base.each_ref().map(|instance| instance.parameters(&self.scene).len());
        let mut columns = DMatrix::zeros(all.len(), widths.iter().sum());
        for (k, instance) in base.iter().enumerate() {
            let first: usize = widths[..k].iter().sum();
            for (point, state) in states.iter().enumerate() {
                r_test_reading(instance, &self.scene, &[], state, Point3::origin(), &mut |i, reading| {
                    let mut rows = columns.view_mut((3 * point, first + i), (3, 1));
                    rows += reading;
                });
            }
        }
        let svd = columns.svd(true, false);
        let u = svd.u.expect("asked for");
        let kept = svd.singular_values.iter().filter(|s| **s > 1e-9 * svd.singular_values.max()).count();
        let u = u.columns(0, kept);
        u * u.tr_mul(all)
    }
}

fn setup(name: &str, ball_in_table_mm: Point3<f64>) -> SceneSetup {
    SceneSetup::r_test(name, ball_in_table_mm).with_plate()
}

/// What is drawn with its numbers, and what it is of.
fn caption(placed: &Placed<'_>, example: &Example, left: Option<f64>, conditions: &str) -> [String; 2] {
    let parameters = placed.instance.parameters(&placed.scene);
    let unit =
        |name: &str| parameters.iter().find(|p| p.name == name).map_or(String::new(), |p| p.unit.text());
    let value = |&(name, value): &(&str, f64)| {
        let short = name.rsplit_once(&format!("{}.", example.id)).map_or(name, |(_, short)| short);
        format!("{short} {} {}", trimmed(value, 9), unit(name))
    };
    let values: Vec<String> = example.values.iter().map(value).collect();
    let share = left.map_or(String::new(), |left| {
        format!("; {:.0} % of it remains after location errors and ball setting", 100.0 * left)
    });
    [format!("{}: {}", example.id, values.join(", ")), format!("{conditions}{share}")]
}

fn poses(machine: Machine, example: &Example) -> Drawing {
    let b_deg: Vec<f64> = (0..13).map(|i| f64::from(i) * 15.0 - 90.0).collect();
    let c_deg: Vec<f64> = (0..24).map(|i| f64::from(i) * 15.0).collect();
    let setups =
        vec![setup("low", Point3::new(150.0, 0.0, 60.0)), setup("high", Point3::new(150.0, 0.0, 160.0))];
    let mut states = Vec::new();
    for (k, setup) in setups.iter().enumerate() {
        for b in &b_deg {
            for c in &c_deg {
                let mut position = AxisValues::default();
                position[Joint::B] = b.to_radians();
                position[Joint::C] = c.to_radians();
                let position =
                    machine.follow(&position, &setup.ball_in_table_mm).expect("X, Y, Z reach every ball");
                states.push(State { position, setup: k, ..State::default() });
            }
        }
    }
    let placed = Placed::new(machine, example, setups, &states);
    let (left, share) = placed.left_um(&states);
    let low = &left[..b_deg.len() * c_deg.len()];
    let xyz_um = [0, 1, 2].map(|k| low.iter().map(|r| r[k]).collect());
    let is_base = BASE.contains(&example.id);
    Drawing {
        caption: caption(
            &placed,
            example,
            (!is_base).then_some(share),
            "R-test at rest, readings in table axes",
        ),
        plot: Plot::Maps { b_deg, c_deg, xyz_um },
    }
}

fn turn(machine: Machine, example: &Example) -> Drawing {
    let setup = setup("low", Point3::new(150.0, 0.0, 60.0));
    let follow = |c_rad: f64| {
        let mut position = AxisValues::default();
        position[Joint::B] = PI / 4.0;
        position[Joint::C] = c_rad;
        machine.follow(&position, &setup.ball_in_table_mm).expect("X, Y, Z reach every ball")
    };
    // 1800°/min, as the shipped sweep.
    let feed_rad_s = 30f64.to_radians();
    let mut states = Vec::new();
    for way in [1.0, -1.0] {
        for i in 0..120 {
            let c_rad = f64::from(i) * TAU / 119.0;
            let (before, after) = (follow(c_rad - 1e-3), follow(c_rad + 1e-3));
            let velocity = AxisValues::from_fn(|l| way * feed_rad_s * (after[l] - before[l]) / 2e-3);
            let travelled = if way > 0.0 { c_rad } else { TAU - c_rad };
            let mut state = State { position: follow(c_rad), velocity, ..State::default() };
            state.direction =
                AxisValues::from_fn(|l| if velocity[l].abs() < 1e-9 { 0.0 } else { velocity[l].signum() });
            state.since_reversal[Joint::C] = travelled;
            states.push(state);
        }
    }
    let placed = Placed::new(machine, example, vec![setup], &states);
    let (left, share) = placed.left_um(&states);
    let mut series = Vec::new();
    for (k, (name, colour)) in XYZ.into_iter().enumerate() {
        for (half, dashed) in [(0..120, false), (120..240, true)] {
            let points = half.map(|i| (states[i].position[Joint::C].to_degrees(), left[i][k])).collect();
            let name = if dashed { String::new() } else { name.into() };
            series.push(Series { name, colour, dashed, points });
        }
    }
    Drawing {
        caption: caption(&placed, example, Some(share), "C turns at 1800°/min, B = 45°; dashed: backward"),
        plot: Plot::Curves { x_label: "C, °", y_label: "reading, µm", series },
    }
}

fn circles(machine: Machine, example: &Example, feeds_mm_min: &[f64]) -> Drawing {
    let mut states = Vec::new();
    for feed_mm_min in feeds_mm_min {
        for way in [1.0, -1.0] {
            states.extend(
                (0..180).map(|i| on_circle((f64::from(i) + 0.5) * TAU / 180.0, way, feed_mm_min / 60.0)),
            );
        }
    }
    let bar = SceneSetup::ball_bar("bar", Point3::origin());
    let placed = Placed::new(machine, example, vec![bar], &states);
    let mut traces = Vec::new();
    for (k, feed_mm_min) in feeds_mm_min.iter().enumerate() {
        let of_feed = &states[360 * k..360 * (k + 1)];
        let radial: Vec<(f64, f64)> = of_feed
            .iter()
            .map(|state| {
                let angle = state.position[Joint::Y].atan2(state.position[Joint::X]).rem_euclid(TAU);
                let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
                (angle, placed.reading_mm(state).dot(&outward) * 1e3)
            })
            .collect();
        // Centre and mean radius by projection: the angles are evenly spread. At two feeds the mean is what differs.
        let n = radial.len() as f64;
        let sum = |f: &dyn Fn(f64) -> f64| radial.iter().map(|(angle, r)| r * f(*angle)).sum::<f64>() / n;
        let mean = if feeds_mm_min.len() == 1 { sum(&|_| 1.0) } else { 0.0 };
        let (x, y) = (2.0 * sum(&f64::cos), 2.0 * sum(&f64::sin));
        let centred = radial.iter().map(|&(angle, r)| (angle, r - mean - x * angle.cos() - y * angle.sin()));
        let centred: Vec<(f64, f64)> = centred.collect();
        let colour = XYZ[[2, 0][k % 2]].1;
        for (half, dashed) in [(&centred[..180], false), (&centred[180..], true)] {
            let way = if dashed { "clockwise" } else { "counter-clockwise" };
            traces.push(Series {
                name: format!("{way}, {feed_mm_min} mm/min"),
                colour,
                dashed,
                points: half.to_vec(),
            });
        }
    }
    Drawing {
        caption: caption(&placed, example, None, "Circle in X, Y, radius 150 mm, centred"),
        plot: Plot::Polar { traces },
    }
}

/// A point of a circle run counter-clockwise (`way` 1) or clockwise.
fn on_circle(angle: f64, way: f64, feed_mm_s: f64) -> State {
    let mut state = State::default();
    let per_s = way * feed_mm_s / RADIUS_MM;
    // X turns round at 0° and 180°, Y at 90° and 270°.
    for (letter, phase) in [(Joint::X, angle), (Joint::Y, angle - PI / 2.0)] {
        state.position[letter] = RADIUS_MM * phase.cos();
        state.velocity[letter] = -RADIUS_MM * per_s * phase.sin();
        state.acceleration[letter] = -RADIUS_MM * per_s * per_s * phase.cos();
        state.direction[letter] = state.velocity[letter].signum();
        let turned_at = -RADIUS_MM * state.direction[letter];
        state.since_reversal[letter] = (state.position[letter] - turned_at).abs();
    }
    state
}

fn over_time(machine: Machine, example: &Example, span_s: f64) -> Drawing {
    let frame_degc = |time_s: f64| 20.0 + 2.0 * (1.0 - (TAU * time_s / span_s).cos());
    let states: Vec<State> = (0..=200)
        .map(|i| {
            let time_s = span_s * f64::from(i) / 200.0;
            let mut state = State {
                time_s: Some(time_s),
                temperature_degc: vec![frame_degc(time_s)],
                ..State::default()
            };
            // A short look is one at a machine in motion.
            state.velocity[Joint::C] = if span_s < 60.0 { 0.1 } else { 0.0 };
            state
        })
        .collect();
    let placed = Placed::new(machine, example, vec![setup("low", Point3::new(150.0, 0.0, 60.0))], &states);
    let (unit, x_label) = if span_s < 60.0 { (1.0, "time, s") } else { (60.0, "time, min") };
    let time = |state: &State| state.time_s.unwrap_or_default() / unit;
    let mut series = components(&states, &placed, &time);
    if placed.instance.about().is_some_and(|about| about.needs.contains(&crate::Need::Temperature)) {
        let points = states.iter().map(|s| (time(s), s.temperature_degc[0] - 20.0)).collect();
        series.push(Series { name: "T, K".into(), colour: GREY, dashed: true, points });
    }
    Drawing {
        caption: caption(&placed, example, None, &shape_text(&placed, example)),
        plot: Plot::Curves { x_label, y_label: "reading, µm", series },
    }
}

fn shape_text(placed: &Placed<'_>, example: &Example) -> String {
    let names = placed.instance.shapes(&placed.scene).names;
    let pairs: Vec<String> =
        names.iter().zip(example.shape).map(|(name, value)| format!("{name} {value}")).collect();
    format!("At one pose; {}", pairs.join(", "))
}

fn stop_and_go(machine: Machine, example: &Example) -> Drawing {
    let states: Vec<State> = (0..=180)
        .map(|i| {
            let time_s = f64::from(i) / 6.0;
            let mut state = State { time_s: Some(time_s), ..State::default() };
            if ((time_s / 5.0) as usize).is_multiple_of(2) {
                state.velocity[Joint::C] = 0.02;
            }
            state
        })
        .collect();
    let placed = Placed::new(machine, example, vec![setup("low", Point3::new(150.0, 0.0, 60.0))], &states);
    let series = components(&states, &placed, &|state| state.time_s.unwrap_or_default());
    Drawing {
        caption: caption(&placed, example, None, "The axis turns slowly for 5 s, stands for 5 s, and so on"),
        plot: Plot::Curves { x_label: "time, s", y_label: "reading, µm", series },
    }
}

fn deflection(machine: Machine, example: &Example) -> Drawing {
    let states: Vec<State> = (0..=40)
        .map(|i| State {
            deflection_mm: Vector3::new(f64::from(i) / 40.0 - 0.5, 0.0, 0.0),
            ..State::default()
        })
        .collect();
    let placed = Placed::new(machine, example, vec![setup("low", Point3::new(150.0, 0.0, 60.0))], &states);
    let series = components(&states, &placed, &|state| state.deflection_mm.x);
    Drawing {
        caption: caption(&placed, example, None, "The ball is moved along the nest's x"),
        plot: Plot::Curves { x_label: "deflection, mm", y_label: "error of reading, µm", series },
    }
}

fn components(states: &[State], placed: &Placed<'_>, abscissa: &dyn Fn(&State) -> f64) -> Vec<Series> {
    let readings: Vec<Vector3<f64>> = states.iter().map(|state| placed.reading_mm(state) * 1e3).collect();
    XYZ.into_iter()
        .enumerate()
        .map(|(k, (name, colour))| {
            let points = states.iter().zip(&readings).map(|(state, r)| (abscissa(state), r[k])).collect();
            Series { name: name.into(), colour, dashed: false, points }
        })
        .collect()
}
