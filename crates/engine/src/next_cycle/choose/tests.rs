use super::super::rivals_named;
use super::*;
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Point, Quality};
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_machine::shipped;

const WHITE_MM: f64 = 0.3e-3;

/// A run of the C sweep in which one effect is hidden, with location errors, a setting and white noise.
fn measured(hidden: &str, value: f64, seed: u64) -> Experiment {
    let machine = shipped::machine("table-bc").unwrap();
    let text = include_str!("../../../../../config/cycles/r-test-sweep-c.toml");
    let cycle = Cycle::parse("sweep.toml", text).unwrap();
    let point = |state| Point {
        state,
        reading_mm: [0.0; 3],
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    };
    let states = cycle.visits(&machine, &Pace::default()).unwrap().states;
    let mut run = Run {
        name: "sweep".into(),
        machine: machine.clone(),
        kind: RunKind::OnTheFly,
        setups: cycle.setups.clone(),
        channels: Vec::new(),
        points: states.into_iter().map(point).collect(),
    };
    let silent = Experiment::new(&[run.clone()]).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut reading = DVector::from_fn(silent.rows(), |_, _| {
        let draw: f64 = StandardNormal.sample(&mut rng);
        draw * WHITE_MM
    });
    for (id, size) in [("location-errors", 5e-3), ("ball-setting", 10e-3), (hidden, value)] {
        let instance = Instance::find(id, &machine).unwrap();
        let columns = silent.columns(&instance, &[]);
        let names = instance.parameters(&silent.scene);
        for (column, parameter) in columns.column_iter().zip(names) {
            let scale = if id != hidden && parameter.unit.symbol == "urad" { 1e-2 } else { 1.0 };
            reading += column * (size * scale);
        }
    }
    for (i, point) in run.points.iter_mut().enumerate() {
        point.reading_mm = std::array::from_fn(|k| reading[3 * i + k]);
    }
    Experiment::new(&[run]).unwrap()
}

fn with(id: &str) -> Model {
    let mut model = Model::base("table-bc");
    model.effects.push(ModelEffect { id: id.into(), ..ModelEffect::default() });
    model
}

fn rivals(ids: &[&str]) -> Rivals {
    let ids: Vec<String> = ids.iter().map(|id| id.to_string()).collect();
    rivals_named(&ids, &shipped::machine("table-bc").unwrap()).unwrap()
}

#[test]
fn the_expected_separation_is_what_the_fits_of_both_rivals_really_differ_by() {
    for (right, value, wrong) in [("backlash:C", 8e-6, "servo-lag:C"), ("servo-lag:C", 8e-6, "backlash:C")] {
        for seed in 0..2 {
            let experiment = measured(right, value, seed);
            let fit = |id: &str| {
                let options = crate::fit::Options { outliers: crate::Outliers::Keep, ..Default::default() };
                crate::identify(&experiment, &with(id), &options).unwrap()
            };
            let (kept, lost) = (fit(right), fit(wrong));
            let freedom = kept.degrees_of_freedom as f64;
            let really_ln = freedom * (lost.rms_mm / kept.rms_mm).ln();
            let rivals = rivals(&[right, wrong]);
            let planned = plan(&experiment, &Model::base("table-bc"), &rivals, &Options::default()).unwrap();
            let expected_ln = planned.before_ln;
            // Lower bound by design: the parameter is let go as far as 95 % of what the data leave open, and the rival may take
            // refuge in coloured noise.
            assert!(really_ln > 15.0, "{really_ln}");
            assert!(
                (0.3..=1.1).contains(&(expected_ln / really_ln)),
                "{right} {seed}: {expected_ln} {really_ln}"
            );
        }
    }
}

#[test]
fn rivals_that_are_in_the_model_or_alone_are_refused() {
    let experiment = measured("backlash:C", 8e-6, 0);
    let options = Options::default();
    let pair = rivals(&["backlash:C", "servo-lag:C"]);
    let refused =
        |model: &Model, rivals: &Rivals| plan(&experiment, model, rivals, &options).unwrap_err().to_string();
    assert!(refused(&with("backlash:C"), &pair).contains("holds backlash:C already"));
    assert!(refused(&Model::base("table-bc"), &rivals(&["backlash:C"])).contains("name two or more"));
}

#[test]
fn the_chosen_cycle_can_be_run_and_read_back() {
    let experiment = measured("backlash:C", 8e-6, 1);
    let pair = rivals(&["backlash:C", "setup-slip"]);
    let plan = plan(&experiment, &Model::base("table-bc"), &pair, &Options::default()).unwrap();
    for row in plan.considered.iter().filter(|row| row.cycle.is_some()) {
        let cycle = row.cycle.as_ref().unwrap();
        let read = Cycle::parse("next.toml", &cycle.to_text()).unwrap();
        let visits = read.visits(experiment.machine(), &Pace::default()).unwrap();
        assert!((visits.duration_s / 60.0 - row.minutes).abs() < 0.01, "{}", row.name);
    }
}

#[test]
fn rivals_that_the_present_data_separate_are_not_said_to_be_confounded_everywhere() {
    let experiment = measured("backlash:C", 8e-6, 0);
    let pair = rivals(&["backlash:C", "servo-lag:C"]);
    let plan = plan(&experiment, &Model::base("table-bc"), &pair, &Options::default()).unwrap();
    assert!(plan.next.is_none() && plan.before_ln > Options::default().separated_ln, "{}", plan.before_ln);
    assert!(plan.answer.contains("No further cycle is needed"), "{}", plan.answer);
}
