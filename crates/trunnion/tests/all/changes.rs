//! What changed from one run to the next.

use crate::mistakes::{Files, READINGS};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use trunnion::Model;
use trunnion::history::{Keeper, Wanted, changed, history};
use trunnion_cycles::RunKind;
use trunnion_record::RunHeader;

/// The points of a run, written into a folder of their own.
fn written(files: &Files, folder: &Path, name: &str) -> Vec<PathBuf> {
    let own = folder.join(name);
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("setup.toml"), &files.setup).unwrap();
    std::fs::write(own.join("points.csv"), files.text()).unwrap();
    vec![own.join("points.csv")]
}

/// Readings that scatter ten times as much are no change of a value: those of the day itself fit them no better.
#[test]
fn a_run_that_only_scatters_more_is_not_said_to_differ_from_what_the_values_predict() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Files::committed("points-nothing-hidden");
    let model = files.open().base_model();
    let earlier = written(&files, folder.path(), "earlier");
    let state = Cell::new(7_u64);
    for reading in READINGS {
        files.change(reading, |um| {
            state.set(
                state.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407),
            );
            um + 10.0 * ((state.get() >> 33) as f64 / (1_u64 << 31) as f64 - 0.5)
        });
    }
    let later = written(&files, folder.path(), "later");
    let change = changed([earlier, later], &model, &mut Keeper::default()).unwrap();
    let words = change.words.join(" ");
    assert!(words.contains("No value changed significantly: values of its own fit"), "{words}");
    assert!(words.contains("The model leaves more") && !words.contains("differs"), "{words}");
}

/// A recording of a spindle at rest that grows by 12 µm with this time constant, read along it every 30 s.
fn grown(folder: &Path, day: u64, tau_s: f64) -> PathBuf {
    let mut rng = ChaCha8Rng::seed_from_u64(day);
    let mut text = String::from("setup,time_s,x_mm,y_mm,z_mm,l_mm\n");
    for k in 0..120 {
        let time_s = 30.0 * f64::from(k);
        let scatter: f64 = StandardNormal.sample(&mut rng);
        let l_um = -12.0 * (1.0 - (-time_s / tau_s).exp()) + 0.1 * scatter;
        text += &format!("rest,{time_s},0,0,0,{:.6}\n", l_um * 1e-3);
    }
    let setup = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n[[setup]]\nname = \"rest\"\ninstrument = \"diagonal\"\n\
                 ball_in_table_mm = [0, 0, 0]\ndirection = [0, 0, 1]\n";
    let [points, recording] = ["csv", "mcap"].map(|ending| folder.join(format!("day-{day}.{ending}")));
    std::fs::write(folder.join("setup.toml"), setup).unwrap();
    std::fs::write(&points, text).unwrap();
    let run = trunnion::read(&points, None).unwrap().run;
    let header = RunHeader {
        machine_text: trunnion::files::machine_text("three-axis").unwrap(),
        setups: run.setups.clone(),
        wall_start_ns: day as i64 * 86_400_000_000_000,
        ..RunHeader::new(&run.name, RunKind::Static, "three-axis")
    };
    trunnion_record::write_run(&recording, &header, &run).unwrap();
    recording
}

/// The growth stays; how fast it comes does not.
#[test]
fn a_time_constant_that_changed_is_outside_its_limits_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let runs: Vec<Vec<PathBuf>> =
        (1..=7).map(|day| vec![grown(folder.path(), day, if day < 7 { 900.0 } else { 400.0 })]).collect();
    let text = format!("{}[[effect]]\nid = \"spindle-growth\"\n", Model::base("three-axis").text());
    let wanted = Wanted { model: Some(Model::parse("m.toml", text).unwrap()), ..Wanted::default() };
    let history = history(&runs, &wanted, &mut Keeper::default()).unwrap();
    let words = history.change.as_ref().map_or_else(String::new, |change| change.words.join(" "));
    assert!(words.contains("tau_s by −") && !words.contains("no effect explains it"), "{words}");
    let tau = history.watched.iter().find(|one| one.name == "tau_s").unwrap();
    assert_eq!((tau.effect.as_str(), tau.unit.as_str(), tau.points.len()), ("spindle-growth", "s", 7));
    let last = tau.points.last().unwrap();
    assert!((last.value - 400.0).abs() < 4.0 * last.u && last.u < 20.0, "{last:?}");
    let alarms: Vec<_> = history.runs.iter().map(|run| run.alarms.clone()).collect();
    assert_eq!((alarms[5].len(), &alarms[6][..]), (0, &["tau_s".to_string()][..]), "{alarms:?}");
}
