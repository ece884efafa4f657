//! The unit left out of a fit is called by what it is, and what cannot be known gets no figure.

use crate::common::points_run;
use trunnion_core::Joint;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, LeftOut, identify};

fn both_ways() -> Run {
    points_run("points-nothing-hidden")
}

/// The points with C going forward: each pose once.
fn forward() -> Run {
    let mut run = both_ways();
    run.points.retain(|point| point.state.direction[Joint::C] > 0.0);
    run
}

/// Only the points of one setup.
fn of_setup(mut run: Run, setup: usize) -> Run {
    run.points.retain(|point| point.state.setup == setup);
    run
}

fn fit(runs: &[Run], model: &Model) -> Identification {
    identify(&Experiment::new(runs).unwrap(), model, &Options::default()).unwrap()
}

fn left_out(runs: &[Run]) -> Option<LeftOut> {
    fit(runs, &Model::base("table-bc")).holdout.map(|holdout| holdout.left_out)
}

#[test]
fn the_unit_left_out_is_called_by_what_it_is() {
    assert_eq!(left_out(&[both_ways()]), Some(LeftOut::Passes));
    assert_eq!(left_out(&[forward()]), Some(LeftOut::Setups));
    assert_eq!(left_out(&[of_setup(forward(), 0), of_setup(forward(), 1)]), Some(LeftOut::Runs));
    assert_eq!(left_out(&[of_setup(forward(), 0)]), Some(LeftOut::Blocks));
}

#[test]
fn units_that_share_no_unknown_predict_nothing_of_each_other() {
    let mut model = Model::base("table-bc");
    model.effects.retain(|entry| entry.id == "ball-setting");
    assert!(fit(&[both_ways()], &model).holdout.is_some(), "two passes share the ball of a setup");
    assert_eq!(fit(&[forward()], &model).holdout, None);
}

/// Of the two time constants of a drift that is not there one pass tells nothing: in another its noise alone would be an error of 0.7 µm.
#[test]
fn what_the_others_hardly_know_is_no_prediction() {
    let held_out_mm = |model: &Model| fit(&[both_ways()], model).holdout.expect("passes").rms_mm;
    let mut with_drift = Model::base("table-bc");
    with_drift
        .effects
        .push(trunnion_effects::ModelEffect { id: "thermal-drift".into(), ..Default::default() });
    let ratio = held_out_mm(&with_drift) / held_out_mm(&Model::base("table-bc"));
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn without_a_repeated_pose_the_repeatability_is_not_known() {
    let fit = fit(&[forward()], &Model::base("table-bc"));
    assert_eq!(fit.repeatability, None);
}

#[test]
fn the_repeatability_is_that_of_the_readings_whatever_the_model() {
    let of = |run: Run, model: &Model| fit(&[run], model).repeatability.unwrap();
    let mut larger = Model::base("table-bc");
    larger.effects.push(trunnion_effects::ModelEffect { id: "backlash:C".into(), ..Default::default() });
    let clean = of(both_ways(), &Model::base("table-bc"));
    assert_eq!(clean, of(both_ways(), &larger));
    let mut spiked = both_ways();
    for i in [40, 123, 290] {
        spiked.points[i].reading_mm[0] += 0.020;
    }
    let ratio = of(spiked, &Model::base("table-bc")).sigma_mm / clean.sigma_mm;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}
