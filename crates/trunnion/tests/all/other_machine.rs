//! A model file of one machine, asked about runs of another.

use std::path::Path;
use trunnion::results::DoubtReason;
use trunnion::{Error, Experiment, Fit, FormulaText, Model};

const SAG: &str = "gravity-sag:B";

fn run() -> Experiment {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity");
    trunnion::open(folder.join("points.csv")).unwrap()
}

/// With kept values, and called after this machine; the run is of `table-bc`.
fn model_of(machine: &str, run: &Experiment) -> Model {
    let step = run.fit(&run.base_model()).unwrap().add(SAG).unwrap().dated("2026-03-01").unwrap();
    let text = step.model().text().replace("\"table-bc\"", &format!("\"{machine}\""));
    assert_eq!(text.contains("\"table-bc\""), machine == "table-bc");
    Model::parse("m.toml", text).unwrap()
}

fn doubted(fit: &Fit) -> Vec<String> {
    let doubts = fit.results().doubts;
    doubts
        .into_iter()
        .filter(|doubt| doubt.reason == DoubtReason::OtherMachine)
        .map(|doubt| doubt.words)
        .collect()
}

#[test]
fn values_of_another_machine_are_not_taken_and_those_of_these_runs_do_not_go_into_its_file() {
    let run = run();
    let model = model_of("table-ac", &run);
    let fit = run.fit(&model).unwrap();
    let added = || fit.add_as("unbalance:C", &FormulaText::default())?.dated("2026-03-02").map(drop);
    let refused: [Result<(), Error>; 6] = [
        model.predict(&run).map(drop),
        fit.predict(&run).map(drop),
        model.compare_frozen(&run).map(drop),
        fit.keeping("2026-03-02").map(drop),
        added(),
        fit.remove(SAG, "2026-03-02", None).map(drop),
    ];
    for refused in refused {
        let error = trunnion::chain(&refused.unwrap_err());
        assert!(
            error.starts_with("the model file is of machine \"table-ac\", run points-gravity was measured on machine \"table-bc\""),
            "{error}"
        );
        assert!(error.ends_with("write `machine = \"table-bc\"` into this file"), "{error}");
    }
}

#[test]
fn effects_of_a_model_file_of_another_machine_are_fitted_with_a_doubt_that_names_both() {
    let run = run();
    let fit = run.fit(&model_of("table-ac", &run)).unwrap();
    let [words] = &doubted(&fit)[..] else { panic!("{:?}", doubted(&fit)) };
    assert!(words.contains("table-ac") && words.contains("table-bc"), "{words}");
    let diagnosed = fit.diagnose().unwrap();
    for surface in [fit.summary(), diagnosed.summary(), diagnosed.compare().summary()] {
        let surface = surface.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(surface.contains(&format!("Doubt: {words}")), "{surface}");
    }
}

#[test]
fn a_model_that_names_its_machine_by_name_or_file_is_taken_without_a_doubt() {
    let run = run();
    for machine in ["table-bc", "machines/table-bc.toml"] {
        let model = model_of(machine, &run);
        assert_eq!(doubted(&run.fit(&model).unwrap()), [""; 0], "{machine}");
        model.predict(&run).unwrap();
    }
}
