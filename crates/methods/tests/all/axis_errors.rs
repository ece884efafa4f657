//! Tables of axis errors against the motions of the model they stand for, over the whole catalogue.

use crate::common;
use std::collections::BTreeSet;
use trunnion_core::{AxisValues, Joint, State, Twist};
use trunnion_effects::{Instance, Model, ModelEffect};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};
use trunnion_machine::{JointErrors, Site};
use trunnion_methods::{AxisErrors, AxisTable};

/// The tables promise straight lines within 0.02 µm and 0.1 µrad.
const CLOSE: f64 = 2.5e-5;

#[test]
fn every_effect_of_the_catalogue_is_in_the_tables_as_it_moves_or_left_out_with_a_reason() {
    let experiment = Experiment::new(&[common::points_run("points-nothing-hidden")]).unwrap();
    let (mut tabulated, mut left_out) = (BTreeSet::new(), BTreeSet::new());
    for instance in Instance::all(experiment.machine()) {
        let parameters = instance.parameters(&experiment.scene);
        if parameters.is_empty() {
            continue;
        }
        // Held at 3 µm, 3 µrad, …: nothing depends on the data.
        let fixed = parameters.iter().map(|parameter| (parameter.name.clone(), 3.0)).collect();
        let shape = instance.shapes(&experiment.scene).grid.swap_remove(0);
        let entry = ModelEffect { id: instance.id(), fixed, shape, ..ModelEffect::default() };
        let model = Model::of("table-bc", vec![entry]);
        let fit = identify(&experiment, &model, &Options::quick()).unwrap();
        let errors = AxisErrors::new(&experiment, &model, &fit).unwrap();
        if errors.effects.is_empty() {
            assert_eq!(errors.left_out.len(), 1, "{}", instance.id());
            left_out.insert(format!("{}: {}", instance.id(), errors.left_out[0].why));
        } else {
            tables_move_as_the_model(&experiment, &instance, &fit, &errors);
            tabulated.insert(instance.id());
        }
    }
    for id in [
        "location-errors",
        "gravity-sag:B",
        "tilt-error-motion:C",
        "straightness:X",
        "squareness:ZX",
        "angular-motion:Y",
    ] {
        assert!(tabulated.contains(id), "{id} is not in {tabulated:?}");
    }
    for why in [
        "ball-setting: it moves ball, nest or reading, not an axis",
        "backlash:C: it depends on the direction of C",
        "stacked-tilt:C: its motion at C depends on the position of B",
        "thermal-drift: it depends on time",
    ] {
        assert!(left_out.contains(why), "{why} is not in {left_out:#?}");
    }
}

#[test]
fn a_model_that_reports_nothing_of_the_axes_gives_no_table() {
    let experiment = Experiment::new(&[common::points_run("points-nothing-hidden")]).unwrap();
    let entry = |id: &str| ModelEffect { id: id.into(), ..ModelEffect::default() };
    let model = Model::of("table-bc", vec![entry("ball-setting")]);
    let fit = identify(&experiment, &model, &Options::quick()).unwrap();
    let errors = AxisErrors::new(&experiment, &model, &fit).unwrap();
    assert!(errors.axes.is_empty() && errors.left_out.len() == 1);
}

/// At poses of the run, whatever direction and time say: location error and table are the motion of the joint.
fn tables_move_as_the_model(
    experiment: &Experiment,
    instance: &Instance,
    fit: &Identification,
    errors: &AxisErrors,
) {
    let values: Vec<f64> = fit.parameters.iter().map(|parameter| parameter.value.expect("held")).collect();
    for (i, point) in experiment.points.iter().enumerate().step_by(17) {
        // Off the rows of the tables.
        let low_side = 0.37 * (i % 3) as f64;
        let position = AxisValues::from_fn(|letter| {
            let (low, high) = experiment.scene.position_range[letter];
            (point.state.position[letter] + low_side * if letter.is_rotary() { 0.1 } else { 7.0 })
                .clamp(low, high)
        });
        let state = State { position, ..point.state.clone() };
        let mut joints = JointErrors::default();
        instance.motions(&experiment.scene, &fit.effects[0].shape, &state, &mut |parameter, site, twist| {
            let Site::Joint(letter) = site else { panic!("{} moves {site:?}", instance.id()) };
            joints[letter] += twist * values[parameter];
        });
        for letter in Joint::ALL {
            let table = errors.axes.iter().find(|table| table.axis == letter);
            let reported = table.map_or(Twist::default(), |table| interpolated(table, position[letter]));
            let off = joints[letter] + reported * -1.0;
            let size = off.translation_mm.amax().max(off.rotation_rad.amax());
            assert!(size < CLOSE, "{} at {letter} = {}: {size}", instance.id(), position[letter]);
        }
    }
}

fn interpolated(table: &AxisTable, position: f64) -> Twist {
    let above = table.positions.iter().position(|row| *row >= position);
    let error = match above {
        None | Some(0) => table.errors.first().copied().unwrap_or_default(),
        Some(k) => {
            let share = (position - table.positions[k - 1]) / (table.positions[k] - table.positions[k - 1]);
            table.errors[k - 1] * (1.0 - share) + table.errors[k] * share
        }
    };
    table.location + error
}
