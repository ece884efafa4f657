//! Answers on committed data are written as JSON and read back without a change.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;
use std::path::PathBuf;
use trunnion_cycles::{Cycle, Run};
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::{Experiment, diagnosis, fit, next_cycle};
use trunnion_machine::shipped;
use trunnion_methods::notation::{Layout, Notation};
use trunnion_methods::recipes::{MethodOptions, REGISTRY};
use trunnion_methods::volumetric as methods;
use trunnion_results::{
    AxisErrors, CheckedDevice, Comparison, Demo, DemoStep, DevicePlace, DevicesChecked, DevicesFound,
    Diagnosis, ErrorMap, Findings, Identification, Imported, Ladder, LadderRow, Live, LiveProbe,
    LocationErrors, NcProgram, NestCalibrated, Plan, Preview, SignTest, Simulation, Verdict, Volumetric,
    to_json,
};

fn run(folder: &str) -> Run {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(folder);
    let text = |file: &str| std::fs::read_to_string(path.join(file)).unwrap();
    let (points, setup) = (text("points.csv"), text("setup.toml"));
    let files = (("points.csv", points.as_str()), ("setup.toml", setup.as_str()));
    trunnion_record::points_csv::import_files(folder, files.0, files.1, &shipped::machine).unwrap()
}

/// Reads back what is written; the same value, and the same bytes when written again.
fn returns<T: Serialize + DeserializeOwned + PartialEq + Debug>(answer: &T) -> serde_json::Value {
    let text = to_json(answer).unwrap();
    let read: T = serde_json::from_str(&text).unwrap();
    assert_eq!(&read, answer);
    assert_eq!(to_json(&read).unwrap(), text);
    serde_json::from_str(&text).unwrap()
}

#[test]
fn identification_and_diagnosis_of_committed_runs_return() {
    for folder in ["points-gravity", "points-unnamed", "points-nothing-hidden", "points-backlash-and-drift"] {
        let experiment = Experiment::new(&[run(folder)]).unwrap();
        let model = Model::base(&experiment.machine().name);
        let fitted = trunnion_engine::identify(&experiment, &model, &fit::Options::default()).unwrap();
        let mut identification = Identification::from(&fitted);
        let errors = Layout::new(experiment.machine()).of_fit(&fitted, Notation::Relative);
        identification.location_errors = Some(LocationErrors::new(Notation::Relative, &errors));
        let json = returns(&identification);
        assert_eq!(json["format"], "trunnion-identification/1");
        assert_eq!(
            json["outliers"].as_u64().unwrap(),
            json["outlier_points"].as_array().unwrap().len() as u64
        );
        for parameter in json["parameters"].as_array().unwrap() {
            assert_eq!(parameter["observable"], !parameter["value"].is_null(), "{parameter}");
        }
        let diagnosis =
            trunnion_engine::diagnose(&experiment, &model, &diagnosis::Options::default()).unwrap();
        let answer = Diagnosis::from(&diagnosis);
        let json = returns(&answer);
        assert_eq!(json["format"], "trunnion-diagnosis/1");
        assert_eq!(json["verdict"], answer.verdict.as_str());
        let comparison = Comparison::new(&experiment, &fitted, Some(answer));
        let json = returns(&comparison);
        assert_eq!(
            json["residuals"]["points"].as_array().unwrap().len(),
            experiment.points.len(),
            "every point of a short run"
        );
        let readings = || {
            let used = comparison.residuals.points.iter().filter(|point| !point.excluded);
            used.flat_map(|point| &point.residual_um)
        };
        let rms_um = (readings().map(|r| r * r).sum::<f64>() / readings().count() as f64).sqrt();
        assert!((rms_um - comparison.identification.rms_um).abs() < 1e-9 * rms_um, "{rms_um}");
    }
}

#[test]
fn findings_plan_preview_ladder_and_volume_return() {
    let runs = [run("points-gravity")];
    let found: Vec<_> =
        REGISTRY.iter().filter_map(|method| method.apply(&runs, &MethodOptions::default()).ok()).collect();
    assert!(!found.is_empty(), "no method can use this run");
    for findings in &found {
        returns(&Findings::from(findings));
    }
    let experiment = Experiment::new(&runs).unwrap();
    let mut model = Model::base(&experiment.machine().name);
    let rivals = ["backlash:C", "encoder-eccentricity:C"].map(String::from);
    let rivals = next_cycle::rivals_named(&rivals, experiment.machine()).unwrap();
    let plan = next_cycle::plan(&experiment, &model, &rivals, &next_cycle::Options::default()).unwrap();
    returns(&Plan::from(&plan));
    let text = include_str!("../../../../config/cycles/demo-static.toml");
    let cycle = Cycle::parse("demo-static.toml", text).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    returns(&Preview::from(&next_cycle::preview(&machine, &cycle, &next_cycle::Options::default()).unwrap()));
    let fitted = trunnion_engine::identify(&experiment, &model, &fit::Options::default()).unwrap();
    let volume = methods::Volume::of_rotary_axes(3, &experiment.scene).unwrap();
    let map =
        methods::VolumetricMap::new(&experiment, &model, &fitted, volume, methods::Datum::BestFit).unwrap();
    let axes = experiment.machine().joints();
    let accuracy = Volumetric::new(&map, &axes);
    let deviations = ErrorMap::new(&map, &axes);
    returns(&accuracy);
    returns(&deviations);
    // The range in X that is printed is that of the map.
    let x = || deviations.places.iter().map(|place| place.error[0].unwrap());
    let range_um = x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min);
    assert!((range_um - accuracy.values[0].value.unwrap()).abs() < 1e-9 * range_um, "{range_um}");
    let errors = trunnion_methods::AxisErrors::new(&experiment, &model, &fitted).unwrap();
    returns(&AxisErrors::from(&errors));
    model.effects.push(ModelEffect {
        id: "gravity-sag:B".into(),
        ladder: Some(LadderRow { date: "2026-03-01".into(), ..Default::default() }),
        ..ModelEffect::default()
    });
    returns(&Ladder::from(&model));
}

#[test]
fn the_answers_of_commands_that_write_files_or_ask_devices_return() {
    let visits = vec![[("c_deg".into(), 90.0), ("vc_deg_per_s".into(), -12.5)].into()];
    let program = NcProgram { program: "N10 M30\n".into(), visits, ..NcProgram::default() };
    let json = returns(&program);
    assert_eq!(
        (&json["format"], &json["visits"][0]["c_deg"]),
        (&"trunnion-nc-program/1".into(), &90.0.into())
    );
    let json = returns(&Simulation { points: 336, run: "run.mcap".into(), ..Simulation::default() });
    assert_eq!((&json["format"], &json["points"]), (&"trunnion-simulation/1".into(), &336.into()));
    let json = returns(&Imported { points: 336, setups: 2, ..Imported::default() });
    assert_eq!((&json["points"], &json["setups"]), (&336.into(), &2.into()));
    let row = LadderRow { error_before_um: 2.0, error_after_um: 0.5, ..LadderRow::default() };
    let ladder = vec![DemoStep::new("gravity-sag:B", &row)];
    let json = returns(&Demo { ladder, verdict: Verdict::MissingEffect, ..Demo::default() });
    assert_eq!((&json["format"], &json["verdict"]), (&"trunnion-demo/1".into(), &"missing-effect".into()));
    assert!(json["on_the_fly"].is_null() && json["ladder"][0]["error_after_um"] == 0.5, "{json}");
    let place = DevicePlace { address: "/dev/ttyUSB0".into(), ..DevicePlace::default() };
    let json = returns(&DevicesFound { places: vec![place], ..DevicesFound::default() });
    assert_eq!(json["format"], "trunnion-devices/1");
    assert!(
        json["places"][0]["driver"].is_null() && json["places"][0]["address"] == "/dev/ttyUSB0",
        "{json}"
    );
    let readings = [("probe-1".into(), "0.1234 mm".into())].into();
    let device = CheckedDevice { readings, ..CheckedDevice::default() };
    let json = returns(&DevicesChecked { devices: vec![device], ..DevicesChecked::default() });
    assert_eq!(json["devices"][0]["readings"]["probe-1"], "0.1234 mm");
    let json = returns(&NestCalibrated { steps: 12, ..NestCalibrated::default() });
    assert_eq!((&json["format"], &json["steps"]), (&"trunnion-nest/1".into(), &12.into()));
    assert_eq!(returns(&SignTest::default())["finding"], "open");
    let probe = LiveProbe { value_mm: Some(1.25), range_mm: Some([0.0, 2.0]), ..LiveProbe::default() };
    let json = returns(&Live { probes: vec![probe], ..Live::default() });
    assert_eq!(
        (&json["format"], &json["probes"][0]["zone"]),
        (&"trunnion-live/1".into(), &"no-value".into())
    );
    assert!(json["ball_offset_mm"].is_null() && json["probes"][0]["range_mm"][1] == 2.0, "{json}");
}

#[test]
fn another_format_or_verdict_is_refused() {
    let text = to_json(&Diagnosis::default()).unwrap();
    assert!(serde_json::from_str::<Diagnosis>(&text).is_ok());
    for (found, wanted) in [("trunnion-diagnosis/1", "trunnion-diagnosis/2"), ("not-judged", "all-well")] {
        assert!(serde_json::from_str::<Diagnosis>(&text.replace(found, wanted)).is_err(), "{wanted}");
    }
    assert_eq!(Diagnosis::default().verdict, Verdict::NotJudged);
}
