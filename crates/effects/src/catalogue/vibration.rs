//! Vibration: the tool side swings at one frequency while it is read.
//!
//! u(t) = a cos 2πft + b sin 2πft for each of x, y, z in machine axes             [ISO/TR 230-8 (vibrations of machine tools)]
//! f: a grid up to half the rate of the points. With up to 24 lines 1/(2·duration) apart the whole band is covered; a
//! longer recording has more lines than that, the grid is then spread evenly over octaves and catches a line only within
//! ±1/duration: give a frequency known from a spectrum as `shape = [f]` in the model file.
//! Limits: on the fly; one clock (one run); frequency and phase constant over the recording; a frequency above half the
//! rate of the points reads as its alias, weakened by the averaging within a point.

use crate::subjects::whole_tool_side;
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use trunnion_core::{State, Twist};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "vibration",
    role: Role::CAUSE,
    about: About {
        title: "Vibration of the tool against the table",
        source: "ISO/TR 230-8; docs/design/physics.md §9.17",
        equation: "u(t) = a cos 2πft + b sin 2πft for x, y, z",
        symbols: "a, b amplitudes in machine axes, µm; f frequency, Hz (shape number frequency_hz); t time since the first point, s",
        validity: "Read on the fly with time stamps; constant frequency and phase in one run; below half the rate of the points, else its alias.",
        typical: "0.1–2 µm, 10–100 Hz",
        explanation: "Tool and table swing against each other in time, wherever the axes are.",
        cause: "Pumps, fans, spindle unbalance, neighbouring machines through the floor, or a control loop close to its limit.",
        seen_by: "Readings on the fly at two feeds: its frequency stays when the feed changes, those of screw, teeth and bearings do not; a recording with all axes at rest.",
        needs: &[Need::OnTheFly, Need::TimeStamps],
        helps: &[Need::TwoFeeds, Need::RestAndMotion],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes,
    motions,
    example: Example {
        id: "vibration",
        shape: &[12.0],
        values: &[("x.cos", 0.4), ("x.sin", 0.3), ("z.sin", 0.8)],
        view: View::Time(0.5),
    },
    golden: Golden {
        source: "ISO 2041 (harmonic vibration: acceleration = (2πf)² · displacement)",
        derivation: "0.0987 m/s² at 50 Hz are 1.000 µm, with a period of 20 ms: +1, 0, −1 µm at 0, 5, 10 ms.",
        id: "vibration",
        shape: &[50.0],
        values: &[("x.cos", 1.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { velocity: &[("C", 5.0)], read_um: Some([1.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment {
                velocity: &[("C", 5.0)],
                time_s: 0.005,
                read_um: Some([0.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                velocity: &[("C", 5.0)],
                time_s: 0.01,
                read_um: Some([-1.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.0005,
    },
};

const MOST_LINES: usize = 24;

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    if !scene.on_the_fly || !scene.has_time() {
        return Vec::new();
    }
    let names = ["x.cos", "x.sin", "y.cos", "y.sin", "z.cos", "z.sin"];
    names.map(|name| Parameter::new(name, Unit::UM)).into()
}

fn shapes(scene: &Scene, _: Subject) -> Shapes {
    let (Some(duration_s), Some(step_s)) = (scene.duration_s().filter(|d| *d > 0.0), scene.time_step_s)
    else {
        return Shapes::one("frequency_hz", [1.0], true);
    };
    // Fewer than two swings are a drift.
    let (lowest_hz, highest_hz) = (2.0 / duration_s, 0.5 / step_s);
    let line_hz = 0.5 / duration_s;
    let lines = ((highest_hz - lowest_hz) / line_hz).max(0.0) as usize;
    let frequency_hz = |i: usize| {
        if lines < MOST_LINES {
            lowest_hz + line_hz * i as f64
        } else {
            lowest_hz * (highest_hz / lowest_hz).powf((i as f64 + 0.5) / MOST_LINES as f64)
        }
    };
    Shapes::one("frequency_hz", (0..lines.clamp(1, MOST_LINES)).map(frequency_hz), true)
}

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(elapsed_s), &[frequency_hz]) = (scene.elapsed_s(state), shape) else { return };
    let (sin, cos) = (TAU * frequency_hz * elapsed_s).sin_cos();
    let (site, into_site) = whole_tool_side(&scene.machine, state);
    for k in 0..3 {
        emit(2 * k, site, Twist::translation(into_site * Vector3::ith(k, cos)));
        emit(2 * k + 1, site, Twist::translation(into_site * Vector3::ith(k, sin)));
    }
}
