//! What an even grid of poses cannot tell apart is confounded, and the plan names a grid that separates it.

use crate::common::{point, points_run, run};
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{InstrumentKind, Joint, NestSide, Setup, State};
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::next_cycle::{Options, next};
use trunnion_engine::{Candidate, Experiment, Problem, diagnose_problem};
use trunnion_machine::shipped;

/// C turns 20 µrad too far and too little in step with teeth; ball at r in the table: the nest reads −e z × r.
fn with_teeth(teeth: f64) -> Run {
    let mut run = points_run("points-nothing-hidden");
    for point in &mut run.points {
        let e = 20e-6 * (teeth * point.state.position[Joint::C] + 0.7).sin();
        let ball = run.setups[point.state.setup].ball_in_table_mm;
        point.reading_mm[0] += e * ball.y;
        point.reading_mm[1] -= e * ball.x;
    }
    run
}

/// C stands every 30°: 11 and 13 teeth show once a turn there, 10 and 14 twice.
#[test]
fn teeth_that_show_once_or_twice_a_turn_are_confounded_with_the_encoder() {
    for teeth in [2.0, 11.0, 14.0] {
        let experiment = Experiment::new(&[with_teeth(teeth)]).unwrap();
        let problem = Problem::new(&experiment, &Model::base("table-bc")).unwrap();
        let mut diagnosis = diagnose_problem(&problem, &Default::default()).unwrap();
        let best = &diagnosis.candidates[0];
        let confused = confused(best);
        for either in ["encoder-eccentricity:C", "drive-pitch:C"] {
            assert!(confused.contains(&either), "{teeth}: {either} is none of {confused:?}");
        }
        diagnosis.next_cycle = None;
        let plan = next(&problem, &diagnosis, &Options::default()).unwrap().expect("a plan");
        assert!(plan.before_ln < 1e-6, "{teeth}: these poses separate them? {}", plan.before_ln);
        assert!(plan.next.is_some() && plan.left_open.is_empty(), "{teeth}: {}", plan.answer);
    }
}

/// A circle of a bar in XY both ways, off its centre along Y, X too long by 40 µm/m: along the bar s x cos θ.
fn long_x(seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (radius_mm, centre) = (150.0, Point3::new(0.0, 0.0, 100.0));
    let off_mm: f64 = rng.random_range(0.01..0.03);
    let setup = Setup {
        bar_length_mm: Some(radius_mm),
        ..Setup::new("xy", InstrumentKind::BallBar, NestSide::Table, centre)
    };
    let mut points = Vec::new();
    for way in [1.0, -1.0] {
        for step in 0..72 {
            let (sin, cos) = (way * f64::from(step) * 5.0).to_radians().sin_cos();
            let mut state = State::default();
            let place = [(Joint::X, radius_mm * cos), (Joint::Y, radius_mm * sin), (Joint::Z, centre.z)];
            place.into_iter().for_each(|(joint, mm)| state.position[joint] = mm);
            (state.direction[Joint::X], state.direction[Joint::Y]) =
                (-way * sin.signum(), way * cos.signum());
            let noise: f64 = StandardNormal.sample(&mut rng);
            let dr_mm = 40e-6 * radius_mm * cos * cos - off_mm * sin + 0.3e-3 * noise;
            points.push(point(state, [dr_mm, 0.0, 0.0]));
        }
    }
    run("circle", shipped::machine("three-axis").unwrap(), vec![setup], points)
}

/// On one circle of one radius the square of the deflection can be any wave of two lobes: by millimetres of error of a bar that is
/// deflected by micrometres.
#[test]
fn a_scale_error_on_a_circle_is_no_bar_that_errs_by_millimetres() {
    for seed in 0..6 {
        let experiment = Experiment::new(&[long_x(seed)]).unwrap();
        let problem = Problem::new(&experiment, &Model::base("three-axis")).unwrap();
        let diagnosis = diagnose_problem(&problem, &Default::default()).unwrap();
        let best = &diagnosis.candidates[0];
        assert_ne!(best.effect, "probe-nonlinearity", "{seed}: {:?}", best.confused_with);
        let confused = confused(best);
        for either in ["linear-scale:X", "linear-scale:Y"] {
            assert!(confused.contains(&either), "{seed}: {either} is none of {confused:?}");
        }
    }
}

/// An effect and all that is confounded with it.
fn confused(found: &Candidate) -> Vec<&str> {
    std::iter::once(&found.effect).chain(&found.confused_with).map(String::as_str).collect()
}
