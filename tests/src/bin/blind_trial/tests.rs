//! The instrument itself: sizes are what they are called, and the right model scores as right.

use crate::cases::{Case, Group};
use crate::noise::Kind as NoiseKind;
use crate::score::{captured_unseen, with_set};
use crate::stage::{SIGMA_MM, Stage, experiment, rms, stacked};
use crate::trial::{catalogue_id, stage_case};
use crate::{cases, noise};
use trunnion_effects::{Instance, ModelEffect};
use trunnion_engine::fit::Options;
use trunnion_engine::identify;

fn single(id: &str, noise: NoiseKind, size: f64) -> Case {
    Case { group: Group::Single, hidden: vec![id.into()], noise, size, seed: 5 }
}

#[test]
fn every_visible_effect_has_its_size_and_a_name_in_the_catalogue() {
    let stage = Stage::new();
    let visible = cases::visible(&stage);
    assert!(visible.catalogued.len() > 20 && visible.uncatalogued.len() >= 7, "too little to ask");
    for id in &visible.catalogued {
        Instance::find(&catalogue_id(id), &stage.machine).expect("the catalogue has what it promises");
    }
    for id in visible.catalogued.iter().chain(&visible.uncatalogued) {
        let staged = stage_case(&stage, &single(id, NoiseKind::White, 2.0));
        let size = rms(&stage.trial.surviving(&staged.hidden_mm)) / SIGMA_MM;
        assert!((size - 2.0).abs() < 0.01, "{id}: {size} σ survive");
    }
}

#[test]
fn the_right_model_fitted_without_noise_removes_the_hidden_effect_from_the_unseen_cycle() {
    let stage = Stage::new();
    let mut poor = Vec::new();
    for id in cases::visible(&stage).catalogued {
        let mut staged = stage_case(&stage, &single(&id, NoiseKind::White, 2.0));
        staged.experiment = experiment(&stage.trial.run("noise-free", &stage.trial.ideal_mm(&staged.truth)));
        let captured = |set: &[ModelEffect]| {
            let model = with_set(&stage.machine, set);
            let fit = identify(&staged.experiment, &model, &Options::quick()).expect("it can be fitted");
            captured_unseen(&stage, &staged, &model, &fit)
        };
        let mut right = ModelEffect { id: catalogue_id(&id), ..ModelEffect::default() };
        // Steps of 30° cannot tell n waves a turn from 12 − n: the unseen cycle can, so the number is given.
        if id.starts_with("drive-pitch") {
            right.shape = vec![staged.truth.hidden[0].shape[0]];
        }
        if captured(&[right]) < 0.99 {
            poor.push(id);
        }
        assert!(captured(&[]).abs() < 1e-12, "the base model alone removes nothing");
    }
    assert!(poor.is_empty(), "{poor:?}");
}

#[test]
fn foreign_noise_has_about_the_size_of_real_noise() {
    let stage = Stage::new();
    let surviving = |kind: NoiseKind, seed: u64| {
        let case = Case { group: Group::Null, hidden: vec![], noise: kind, size: 0.0, seed };
        let staged = stage_case(&stage, &case);
        let readings = noise::read_mm(kind, &stage.trial, &staged.truth);
        let noise = stacked(&readings) - stacked(&stage.trial.ideal_mm(&staged.truth));
        rms(&stage.trial.surviving(&noise)) / SIGMA_MM
    };
    let mean = |kind| (0..10).map(|seed| surviving(kind, seed)).sum::<f64>() / 10.0;
    let [white, real, foreign] = NoiseKind::ALL.map(mean);
    assert!((white - 1.0).abs() < 0.03, "{white}");
    assert!(foreign > 1.0 && foreign < 1.5 * real, "{foreign} beside {real}");
}
