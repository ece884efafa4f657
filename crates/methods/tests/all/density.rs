//! A volume is looked at as densely as the waves of its model need, and what lies between the places is stated.

use crate::common::points_run;
use trunnion_core::axis::iso::X;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};
use trunnion_methods::volumetric::{Datum, Volume, VolumetricMap};

const AMPLITUDE_MM: f64 = 2e-3;

/// A model of which nothing is left but a wave of 2 µm along X, once in 12 mm and known without uncertainty.
fn wave(experiment: &Experiment) -> (Model, Identification) {
    let mut model = Model::base("table-bc");
    model.effects.push(ModelEffect { id: "ballscrew-pitch:X".into(), ..ModelEffect::default() });
    let mut fit = identify(experiment, &model, &Options::default()).unwrap();
    fit.effects.last_mut().unwrap().shape = vec![12.0];
    let sine =
        fit.parameters.iter().rposition(|p| p.effect == "ballscrew-pitch:X" && p.name == "sin").unwrap();
    fit.solution.fill(0.0);
    fit.solution[sine] = AMPLITUDE_MM;
    fit.covariance.fill(0.0);
    (model, fit)
}

#[test]
fn a_wave_between_the_places_is_looked_for_or_stated() {
    let experiment = Experiment::new(&[points_run("points-nothing-hidden")]).unwrap();
    let (model, fit) = wave(&experiment);
    let map = |steps: Option<usize>| {
        let volume = Volume::parse("X=-30..36,Y=0,Z=0", steps.unwrap_or(2), &experiment.scene).unwrap();
        let volume = match steps {
            Some(_) => volume,
            None => volume.dense(&experiment, &model, &fit).unwrap(),
        };
        VolumetricMap::new(&experiment, &model, &fit, volume, Datum::BestFit).unwrap()
    };
    let dense = map(None);
    let [looked] = &dense.looked[..] else { panic!("X alone moves: {:?}", dense.looked) };
    assert_eq!(looked.axis, X);
    assert!(looked.step < 12.0 / 4.0 && looked.missed[0] < 0.01 * dense.ranges[0].value, "{looked:?}");
    // From the lowest to the highest of a wave with an amplitude of 2 µm.
    assert!((dense.ranges[0].value / (2.0 * AMPLITUDE_MM) - 1.0).abs() < 0.01, "{:?}", dense.ranges[0]);

    // Four places lie 22 mm apart, at sines of 0, 0.87, 0.87 and 0.
    let coarse = map(Some(4));
    let (range, missed) = (coarse.ranges[0].value, coarse.looked[0].missed[0]);
    assert!((range / AMPLITUDE_MM - 0.75f64.sqrt()).abs() < 1e-3, "{range}");
    assert!(((range + missed) / (2.0 * AMPLITUDE_MM) - 1.0).abs() < 0.01, "{range} and {missed}");
}

#[test]
fn a_range_is_written_with_true_minus_signs_and_read_again() {
    let experiment = Experiment::new(&[points_run("points-nothing-hidden")]).unwrap();
    let words =
        |text: &str| Volume::parse(text, 2, &experiment.scene).unwrap().words(&experiment.scene.machine);
    let written = words("X=-30..-10.5,Y=0,Z=-0,B=-90..90");
    assert_eq!(written, "X −30..−10.5 mm, Y 0 mm, Z 0 mm, B −90..90°, C 0°");
    assert_eq!(words("X=−30..−10.5,Y=0,Z=0,B=−90..90"), written);
}
