//! What an even grid of poses cannot tell apart is confounded, and the plan names a grid that separates it.

use crate::common::points_run;
use trunnion_core::Joint;
use trunnion_effects::Model;
use trunnion_engine::next_cycle::{Options, next};
use trunnion_engine::{Experiment, Problem, diagnosis::diagnose_problem};

/// C turns 20 µrad too far and too little in step with teeth; ball at r in the table: the nest reads −e z × r.
fn with_teeth(teeth: f64) -> trunnion_cycles::Run {
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
        let alike: Vec<&str> =
            std::iter::once(&best.effect).chain(&best.confused_with).map(String::as_str).collect();
        for either in ["encoder-eccentricity:C", "drive-pitch:C"] {
            assert!(alike.contains(&either), "{teeth}: {either} is none of {alike:?}");
        }
        diagnosis.next_cycle = None;
        let plan = next(&problem, &diagnosis, &Options::default()).unwrap().expect("a plan");
        assert!(plan.before_ln < 1e-6, "{teeth}: these poses separate them? {}", plan.before_ln);
        assert!(plan.next.is_some() && plan.left_open.is_empty(), "{teeth}: {}", plan.answer);
    }
}
