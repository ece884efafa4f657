//! Outside data: 336 points of an independent simulator with location errors only (tests/data/PROVENANCE.md).

use crate::common;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};

fn fitted() -> Identification {
    let experiment = Experiment::new(&[common::points_run("points-nothing-hidden")]).expect("points");
    identify(&experiment, &Model::base("table-bc"), &Options::default()).expect("a fit")
}

#[test]
fn location_errors_come_out_as_injected() {
    let fit = fitted();
    let truth: serde_json::Value =
        serde_json::from_str(&common::outside("points-nothing-hidden/truth.json").unwrap()).unwrap();
    for (ours, theirs, limit) in [
        ("EX0B", "EX0B", 0.1),
        ("EZ0B", "EZ0B", 0.1),
        ("EA0B", "EA0B", 0.3),
        ("EB0B", "EB0B", 0.3),
        ("EC0B", "EC0B", 0.3),
        ("EX0C", "EX0C_relative", 0.1),
        ("EY0C", "EY0C_relative", 0.1),
        ("EA0C", "EA0C_relative", 0.3),
    ] {
        let p = fit.parameter(ours).unwrap();
        let truth = truth["location"][theirs].as_f64().unwrap() * p.unit.per_inside;
        let (value, u) = (p.screen_value().unwrap(), p.screen_u().unwrap());
        assert!((value - truth).abs() < limit, "{ours} = {value}, put in {truth}");
        assert!((value - truth).abs() < 4.0 * u, "{ours} = {value} ± {u}, put in {truth}");
    }
}

#[test]
fn conventional_zeros_get_no_number_and_are_named() {
    let fit = fitted();
    for name in ["EZ0C", "EC0C", "EY0B", "EB0C"] {
        let p = fit.parameter(name).unwrap();
        assert!(!p.observable() && p.value.is_none() && p.u.is_none(), "{name} must have no number");
        assert!(fit.unobservable.iter().any(|d| d.direction.contains(name)), "{name} must be named");
    }
    assert_eq!(fit.unobservable.len(), 4);
    let settings = fit.parameters.iter().filter(|p| p.effect == "ball-setting");
    assert!(settings.clone().count() == 6 && settings.clone().all(|p| p.observable()));
    assert_eq!(fit.parameters.iter().filter(|p| p.value.is_none()).count(), 4);
}

#[test]
fn noise_comes_from_repeats_and_the_held_out_error_is_near_it() {
    let fit = fitted();
    let repeatability = fit.repeatability.expect("every pose was measured in both directions");
    assert_eq!(repeatability.repeats, 168);
    let (noise, rms, held_out) = (repeatability.sigma_mm, fit.rms_mm, fit.holdout.unwrap().rms_mm);
    // Put in: noise 0.3 µm, error motions 0.2 µm.
    assert!((0.27e-3..0.35e-3).contains(&noise), "noise {noise}");
    assert!((0.28e-3..0.45e-3).contains(&rms), "rms {rms}");
    assert!(held_out > rms && held_out < 1.3 * rms, "held out {held_out}, rms {rms}");
}
