//! One question has one answer: whoever asks for a figure of a model on a recording gets the same one.
//!
//! On every committed set of points, for the base model and for the model with the first candidate: repeatability, rms, held-out
//! error with its unit, parameters and u of `identify`, of the diagnosis (residual and candidate), of adding an effect and of the
//! row it makes on the ladder.

use std::path::Path;
use trunnion::analysis::{Step, add, diagnose};
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{LadderRow, Model};
use trunnion_engine::fit::Options;
use trunnion_engine::{Diagnosis, Experiment, Identification, identify};
use trunnion_machine::shipped;
use trunnion_record::points_csv::import_files;

/// Where the points are committed.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");

/// Two prints of one figure may differ by this share.
const SAME: f64 = 1e-9;

fn run(folder: &str, kind: RunKind) -> Run {
    let text = |file: &str| std::fs::read_to_string(Path::new(DATA).join(folder).join(file)).unwrap();
    let (points, setup) = (text("points.csv"), text("setup.toml"));
    let files = (("points.csv", points.as_str()), ("setup.toml", setup.as_str()));
    Run { kind, ..import_files(folder, files.0, files.1, &shipped::machine).expect("good files") }
}

/// Every committed set of points; one read on the fly.
fn runs() -> Vec<Run> {
    let mut folders: Vec<String> = std::fs::read_dir(Path::new(DATA))
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().join("points.csv").exists())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    folders.sort();
    assert!(folders.len() >= 5, "{folders:?}");
    let kind = |folder: &str| if folder.starts_with("sweep") { RunKind::OnTheFly } else { RunKind::Static };
    folders.iter().map(|folder| run(folder, kind(folder))).collect()
}

/// What is printed of one model on one recording.
#[derive(Clone, Debug, Default)]
struct Figures {
    rms_um: f64,
    repeatability_um: Option<f64>,
    holdout_um: Option<f64>,
    holdout_unit: Option<String>,
    /// Name, value, u.
    parameters: Vec<(String, Option<f64>, Option<f64>)>,
}

impl Figures {
    fn of_fit(fit: &Identification) -> Self {
        let parameter = |p: &trunnion_engine::FittedParameter| {
            (format!("{} {}", p.effect, p.name), p.screen_value(), p.screen_u())
        };
        Self {
            rms_um: um_from_mm(fit.rms_mm),
            repeatability_um: fit.repeatability.map(|found| um_from_mm(found.sigma_mm)),
            holdout_um: fit.holdout.map(|holdout| um_from_mm(holdout.rms_mm)),
            holdout_unit: fit.holdout.map(|holdout| holdout.left_out.name().into()),
            parameters: fit.parameters.iter().map(parameter).collect(),
        }
    }

    fn of_residual(diagnosis: &Diagnosis, like: &Self) -> Self {
        let residual = &diagnosis.residual;
        Self {
            rms_um: residual.rms_um,
            repeatability_um: residual.noise_um,
            holdout_um: residual.holdout_rms_um,
            holdout_unit: residual.holdout_unit.map(|unit| unit.name().into()),
            parameters: like.parameters.clone(),
        }
    }

    /// The first candidate; what is not said of it is taken from `like`.
    fn of_candidate(diagnosis: &Diagnosis, like: &Self) -> Self {
        let candidate = &diagnosis.candidates[0];
        let mut parameters = like.parameters.clone();
        for (name, value, u) in &mut parameters {
            let Some(name) = name.strip_prefix(&format!("{} ", candidate.effect)) else { continue };
            let own = candidate
                .parameters
                .iter()
                .find(|p| p.name == name)
                .expect("a candidate lists every parameter");
            (*value, *u) = (own.value, own.u);
        }
        Self {
            rms_um: candidate.rms_um_after,
            repeatability_um: diagnosis.residual.noise_um,
            holdout_um: candidate.holdout_rms_um_after,
            holdout_unit: diagnosis.residual.holdout_unit.map(|unit| unit.name().into()),
            parameters,
        }
    }

    fn of_row(row: &LadderRow, after: bool, like: &Self) -> Self {
        let (rms_um, holdout_um) = match after {
            true => (row.error_after_um, row.holdout_after_um),
            false => (row.error_before_um, row.holdout_before_um),
        };
        let (repeatability_um, holdout_unit) = (row.noise_um, row.holdout_unit.clone());
        Self { rms_um, repeatability_um, holdout_um, holdout_unit, parameters: like.parameters.clone() }
    }

    fn assert_same(&self, other: &Self, what: &str) {
        let same = |a: Option<f64>, b: Option<f64>, figure: &str| match (a, b) {
            (Some(a), Some(b)) => assert!((a - b).abs() <= SAME * a.abs(), "{what}: {figure} is {a} and {b}"),
            (a, b) => assert_eq!(a, b, "{what}: {figure}"),
        };
        same(Some(self.rms_um), Some(other.rms_um), "rms");
        same(self.repeatability_um, other.repeatability_um, "repeatability");
        same(self.holdout_um, other.holdout_um, "held-out error");
        assert_eq!(self.holdout_unit, other.holdout_unit, "{what}: unit left out");
        assert_eq!(self.parameters.len(), other.parameters.len(), "{what}");
        for ((name, value, u), (other_name, other_value, other_u)) in
            self.parameters.iter().zip(&other.parameters)
        {
            assert_eq!(name, other_name, "{what}");
            same(*value, *other_value, name);
            same(*u, *other_u, &format!("u of {name}"));
        }
    }
}

fn identified(experiment: &Experiment, model: &Model) -> Figures {
    Figures::of_fit(&identify(experiment, model, &Options::default()).unwrap())
}

/// The figures of a model from everybody who prints them; and the diagnosis.
fn check(experiment: &Experiment, model: &Model, what: &str) -> Diagnosis {
    let figures = identified(experiment, model);
    assert!(figures.holdout_um.is_some() && !figures.parameters.is_empty(), "{what}: {figures:?}");
    let diagnosis = diagnose(experiment, model).unwrap();
    figures.assert_same(
        &Figures::of_residual(&diagnosis, &figures),
        &format!("{what}, residual of the diagnosis"),
    );
    diagnosis
}

fn check_step(experiment: &Experiment, before: &Diagnosis, step: &Step, what: &str) {
    let after = identified(experiment, &step.model);
    after.assert_same(&Figures::of_fit(&step.identification), &format!("{what}, fit of what was added"));
    after.assert_same(&Figures::of_candidate(before, &after), &format!("{what}, candidate"));
    let row = step.entries[0].ladder.as_ref().unwrap();
    after.assert_same(&Figures::of_row(row, true, &after), &format!("{what}, ladder after"));
    let without = Figures::of_fit(&step.before);
    without.assert_same(&Figures::of_residual(before, &without), &format!("{what}, fit before"));
    without.assert_same(&Figures::of_row(row, false, &without), &format!("{what}, ladder before"));
}

#[test]
fn every_surface_gives_the_same_figures() {
    let mut added = 0;
    for run in runs() {
        let name = run.name.clone();
        let model = Model::base(&run.machine.name);
        let experiment = Experiment::new(&[run]).unwrap();
        let diagnosis = check(&experiment, &model, &name);
        let Some(candidate) = diagnosis.candidates.first() else { continue };
        let step = add(&experiment, &model, &candidate.effect, "2026-01-01").unwrap();
        check_step(&experiment, &diagnosis, &step, &format!("{name} + {}", candidate.effect));
        check(&experiment, &step.model, &format!("{name} with {}", candidate.effect));
        added += 1;
    }
    assert!(added >= 3, "only {added} recordings have a candidate");
}
