//! The way a user of the library goes, on committed runs.

use std::path::PathBuf;
use trunnion::results::{Identification, Verdict};
use trunnion::{Error, Model};

fn committed(folder: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(folder).join("points.csv")
}

#[test]
fn the_missing_effect_is_found_added_and_saved() {
    let run = trunnion::open(committed("points-gravity")).unwrap();
    let base = run.fit(&run.base_model()).unwrap();
    let diagnosed = base.diagnose().unwrap();
    assert_eq!(diagnosed.results().verdict, Verdict::MissingEffect);
    let effect = diagnosed.best().unwrap();
    assert_eq!(effect, "gravity-sag:B");

    let step = diagnosed.add(&effect).unwrap().dated("2026-03-01").unwrap();
    assert_eq!(step.before().results(), base.results());
    assert!(step.row().error_after_um < 0.5 * step.row().error_before_um);
    assert!(matches!(step.add(&effect), Err(Error::InModel { .. })));

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.model.toml");
    let commented = format!("# by hand\n{}", base.model().text());
    let by_hand = Model::parse("machine.model.toml", commented).unwrap();
    let step = run.fit(&by_hand).unwrap().add(&effect).unwrap().dated("2026-03-01").unwrap();
    step.model().save(&file).unwrap();
    let loaded = Model::load(&file).unwrap();
    assert!(loaded.text().starts_with("# by hand\n"));
    assert_eq!(loaded.ladder(), step.ladder());
    assert_eq!(run.fit(&loaded).unwrap().results(), step.fit().results());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside the model");

    let without = step.fit().remove(&effect, "2026-03-02", None).unwrap();
    assert_eq!(without.results(), base.results());
    assert!(without.model().text().starts_with("# by hand\n"));
}

#[test]
fn a_verdict_names_all_that_was_found_together() {
    let run = trunnion::open(committed("points-backlash-and-drift")).unwrap();
    let (verdict, why) = run.fit(&run.base_model()).unwrap().verdict();
    assert_eq!(verdict, Verdict::MissingEffect);
    for effect in ["backlash:C", "thermal-drift"] {
        assert!(why.contains(effect), "{why}");
    }
}

#[test]
fn what_comes_in_by_one_act_is_one_step_and_goes_out_together() {
    let run = trunnion::open(committed("points-unnamed")).unwrap();
    let base = run.fit(&run.base_model()).unwrap();
    let diagnosed = base.diagnose().unwrap();
    let effect = diagnosed.best().unwrap();
    let step = diagnosed.add(&effect).unwrap().dated("2026-03-01").unwrap().by("Ada").unwrap();
    let ids: Vec<&str> = step.entries().iter().map(|entry| entry.id.as_str()).collect();
    assert!(ids.len() == 2 && ids[0] == effect, "{ids:?}");
    let read = Model::parse("model.toml", step.model().text().into()).unwrap();
    let ladder = read.ladder();
    let (added, row) = ladder.added().next().unwrap();
    assert_eq!((added, ladder.added().count(), row.by.as_deref()), (effect.as_str(), 1, Some("Ada")));
    assert!((row.error_before_um - base.results().rms_um).abs() < 1e-3, "{row:?}");
    assert!((row.error_after_um - step.fit().results().rms_um).abs() < 1e-3, "{row:?}");
    for id in ids {
        let without = step.fit().remove(id, "2026-03-02", None).unwrap();
        assert_eq!(without.results(), base.results(), "{id}");
        let removed: Vec<_> = without.model().ladder().removed.into_iter().map(|gone| gone.effect).collect();
        assert_eq!(removed, *std::slice::from_ref(&effect));
    }
}

#[test]
fn every_surface_shows_the_same_figures() {
    let run = trunnion::open(committed("points-unnamed")).unwrap();
    let fit = run.fit(&run.base_model()).unwrap();
    let answer = fit.results();
    let json = trunnion::results::to_json(&answer).unwrap();
    assert_eq!(serde_json::from_str::<Identification>(&json).unwrap(), answer);
    assert!(fit.summary().contains(&trunnion::results::number::um(answer.rms_um)));
    assert_eq!(fit.compare().results().identification, answer);
}

#[test]
fn a_run_predicts_itself_as_well_as_its_fit_and_another_machine_is_refused() {
    let run = trunnion::open(committed("points-gravity")).unwrap();
    let fit = run.fit(&run.base_model()).unwrap().add("gravity-sag:B").unwrap().fit().clone();
    let prediction = fit.predict(&run).unwrap();
    let (of_run, rms_um) = (&prediction.runs[0], fit.results().rms_um);
    // Frozen at the values of the least squares: what the outliers of the fit add is all that may differ.
    assert!(of_run.rms_um >= 0.99 * rms_um && of_run.rms_um < 1.5 * rms_um, "{of_run:?}");
    assert!(of_run.inside_95_fraction > 0.9, "{of_run:?}");
    assert!(!of_run.fitted_settings.is_empty());
    assert!(
        of_run
            .fitted_settings
            .iter()
            .all(|name| fit.results().parameter(name).unwrap().effect == "ball-setting")
    );

    let base = run.fit(&run.base_model()).unwrap().predict(&run).unwrap();
    assert!(base.runs[0].rms_um > 2.0 * of_run.rms_um, "without its cause the prediction is worse");
}

#[test]
fn what_cannot_be_opened_is_named() {
    let chain = |error: Error| {
        let mut text = error.to_string();
        let mut cause = std::error::Error::source(&error);
        while let Some(error) = cause {
            text += &format!(": {error}");
            cause = error.source();
        }
        text
    };
    let nowhere = trunnion::open("nowhere/run.mcap").err().unwrap();
    assert!(chain(nowhere).contains("nowhere/run.mcap"));
    let no_setup = trunnion::open(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.csv")).err().unwrap();
    assert!(chain(no_setup).contains("setup.toml"));
    let machine = trunnion::files::machine("table-xy").err().unwrap().to_string();
    assert!(machine.contains("table-xy") && machine.contains("table-bc"), "{machine}");
}

#[test]
fn a_wave_along_an_axis_is_in_the_comparison_its_text_and_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let setup = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n[[setup]]\nname = \"line\"\ninstrument = \"diagonal\"\n\
                 nest = \"spindle\"\nball_in_table_mm = [0.0, 0.0, 0.0]\ndirection = [1.0, 0.0, 0.0]\n";
    std::fs::write(folder.path().join("setup.toml"), setup).unwrap();
    let mut points = String::from("setup,x_mm,y_mm,z_mm,l_mm,time_s\n");
    for k in 0..300 {
        // 0.37 mm is no share of a lead of 10 mm; the rest is a residue without a period.
        let x_mm = 0.05 * f64::from(k);
        let other_mm = 0.3e-3 * (f64::from(k * k % 97) / 97.0 - 0.5);
        let l_mm = x_mm + 5e-3 * (std::f64::consts::TAU * x_mm / 0.37).sin() + other_mm;
        points += &format!("line,{x_mm:.4},0,0,{l_mm:.6},{k}\n");
    }
    std::fs::write(folder.path().join("points.csv"), points).unwrap();
    let run = trunnion::open(folder.path().join("points.csv")).unwrap();
    let compared = run.fit(&run.base_model()).unwrap().compare();
    let answer = compared.results();
    let [spectrum] = &answer.spectra[..] else { panic!("{:?}", answer.spectra.len()) };
    let wave = &spectrum.waves[0];
    assert_eq!((spectrum.axis.as_str(), wave.period.unit.as_str()), ("X", "mm"));
    assert!((wave.period.value - 0.37).abs() < 4.0 * wave.period.u.max(1e-5), "{wave:?}");
    let amplitude_um = wave.period.amplitude.unwrap();
    assert!((amplitude_um - 5.0).abs() < 0.1, "{wave:?}");
    for surface in [compared.summary(), compared.page()] {
        assert!(surface.contains("What repeats along the axes"), "{surface}");
        assert!(surface.contains("X: a wave of"), "{surface}");
    }
}

/// A machine file that is wrong is no name that nobody knows: its line is said, and what is allowed there.
#[test]
fn a_wrong_machine_file_next_to_the_points_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let of_points =
        |name: &str| std::fs::read_to_string(committed("points-gravity").with_file_name(name)).unwrap();
    let setup = of_points("setup.toml").replace("\"table-bc\"", "\"mine.toml\"");
    let machine =
        trunnion::files::machine_text("table-bc").unwrap().replacen("sense = 1\n", "sense = 3\n", 1);
    for (name, text) in
        [("points.csv", of_points("points.csv")), ("setup.toml", setup), ("mine.toml", machine)]
    {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let [points, setup, output] =
        ["points.csv", "setup.toml", "run.mcap"].map(|name| folder.path().join(name));
    let opened = trunnion::open(&points).err().unwrap().to_string();
    let imported = trunnion::tables::import(trunnion::cycles::RunKind::Static, &points, &setup, &output)
        .err()
        .unwrap()
        .to_string();
    for why in [opened, imported] {
        assert!(why.contains("mine.toml:") && why.contains("sense = 3"), "{why}");
    }
}
