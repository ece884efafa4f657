//! Numbers of a model that leaves more than repeats allow are marked, without a diagnosis; only a diagnosis calls a model adequate.

use std::path::PathBuf;
use trunnion::results::Verdict;
use trunnion::{Experiment, Fit};

const SAID: &str = "These numbers hold only as far as the model does";

fn open(folder: &str) -> Experiment {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    trunnion::open(data.join(folder).join("points.csv")).unwrap()
}

fn says(fit: &Fit) -> bool {
    fit.summary().replace('\n', " ").contains(SAID)
}

#[test]
fn numbers_without_the_missing_effect_are_marked_and_with_it_they_are_not() {
    let run = open("points-gravity");
    let base = run.fit(&run.base_model()).unwrap();
    assert_eq!(base.results().model_adequate, Some(false));
    assert!(says(&base) && base.summary().contains("trunnion diagnose"), "{}", base.summary());
    let compared = base.compare();
    assert_eq!(compared.results().identification.model_adequate, Some(false));
    assert_eq!(compared.page().matches(SAID).count(), 1, "the page says it once");
    let with = base.add("gravity-sag:B").unwrap().fit().clone();
    assert_ne!(with.results().model_adequate, Some(false));
    assert!(!says(&with), "{}", with.summary());
}

#[test]
fn a_model_that_lacks_nothing_is_called_adequate_by_a_diagnosis_alone() {
    let run = open("points-nothing-hidden");
    let fit = run.fit(&run.base_model()).unwrap();
    assert_eq!(fit.results().model_adequate, None, "a small effect may be missing");
    assert!(!says(&fit));
    let compared = fit.compare();
    assert_eq!(compared.diagnosed().results().verdict, Verdict::NoiseFloor);
    assert_eq!(compared.results().identification.model_adequate, Some(true));
    assert!(!compared.page().contains(SAID));
}

/// Every pose once: nothing says how readings repeat, so nothing says whether the model is adequate.
#[test]
fn without_repeats_a_fit_does_not_say_whether_its_model_is_adequate() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity");
    let text = std::fs::read_to_string(data.join("points.csv")).unwrap();
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let direction = head.iter().position(|cell| *cell == "direction_c").unwrap();
    let forward = |line: &&str| !line.split(',').nth(direction).unwrap().starts_with('-');
    let once: Vec<&str> = text.lines().filter(forward).collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), once.join("\n") + "\n").unwrap();
    std::fs::copy(data.join("setup.toml"), folder.path().join("setup.toml")).unwrap();
    let run = trunnion::open(folder.path().join("points.csv")).unwrap();
    let fit = run.fit(&run.base_model()).unwrap();
    assert_eq!((fit.results().noise_um, fit.results().model_adequate), (None, None));
    assert!(!says(&fit));
    // It leaves 6 µm, which nobody can call noise or an effect: the numbers do not go out without that.
    let summary = fit.summary().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(summary.contains("No pose was measured twice: whether the"), "{summary}");
}
