//! One question has one answer: whoever asks for a figure of a model on a recording gets the same one.
//!
//! On every committed set of points, for the base model and for the model with the first candidate: repeatability, rms, held-out
//! error with its unit, parameters and u of `identify`, of the diagnosis (residual and candidate), of the comparison, of adding an
//! effect, of the row it makes on the ladder, as JSON, in the terminal and on the page, which are read as a person reads them.

use serde::Serialize;
use std::path::{Path, PathBuf};
use trunnion::cycles::RunKind;
use trunnion::results::number::{um, um_or_dash, value_and_u};
use trunnion::results::sentences::left_out;
use trunnion::results::{Diagnosis, Identification, LadderRow, LeftOut, to_json};
use trunnion::{Diagnosed, Experiment, Fit, Step};

/// Where the points are committed.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");

/// Two prints of one figure may differ by this share.
const SAME: f64 = 1e-9;

/// Every committed set of points with its name; those of a sweep were read on the fly.
fn recordings() -> Vec<(String, Experiment)> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(Path::new(DATA))
        .unwrap()
        .map(|entry| entry.unwrap().path().join("points.csv"))
        .filter(|file| file.exists())
        .collect();
    files.sort();
    assert!(files.len() >= 5, "{files:?}");
    let open = |file: PathBuf| {
        let mut recording = trunnion::read(&file, None).unwrap();
        let name = recording.run.name.clone();
        if name.starts_with("sweep") {
            recording.run.kind = RunKind::OnTheFly;
        }
        (name, Experiment::of_recordings(vec![(file, recording)]).unwrap())
    };
    files.into_iter().map(open).collect()
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

/// The unit as JSON and model file write it.
fn word(unit: Option<LeftOut>) -> Option<String> {
    unit.map(|unit| serde_json::to_value(unit).unwrap().as_str().unwrap().into())
}

impl Figures {
    fn of_fit(fit: &Identification) -> Self {
        let parameters = fit.parameters.iter().map(|p| (format!("{} {}", p.effect, p.name), p.value, p.u));
        Self {
            rms_um: fit.rms_um,
            repeatability_um: fit.noise_um,
            holdout_um: fit.holdout_rms_um,
            holdout_unit: word(fit.holdout_unit),
            parameters: parameters.collect(),
        }
    }

    fn of_residual(diagnosis: &Diagnosis, like: &Self) -> Self {
        let residual = &diagnosis.residual;
        Self {
            rms_um: residual.rms_um,
            repeatability_um: residual.noise_um,
            holdout_um: residual.holdout_rms_um,
            holdout_unit: word(residual.holdout_unit),
            parameters: like.parameters.clone(),
        }
    }

    /// The first candidate; what is not said of it is taken from `like`.
    fn of_candidate(diagnosis: &Diagnosis, like: &Self) -> Self {
        let candidate = &diagnosis.candidates[0];
        let mut parameters = like.parameters.clone();
        for (name, value, u) in &mut parameters {
            let Some(name) = name.strip_prefix(&format!("{} ", candidate.effect)) else { continue };
            let own = candidate.parameters.iter().find(|p| p.name == name);
            let own = own.expect("a candidate lists every parameter");
            (*value, *u) = (own.value, own.u);
        }
        Self {
            rms_um: candidate.rms_um_after,
            holdout_um: candidate.holdout_rms_um_after,
            parameters,
            ..Self::of_residual(diagnosis, like)
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

/// What JSON holds of an answer about a fit.
fn in_json(answer: &impl Serialize, at: &str) -> Identification {
    let json: serde_json::Value = serde_json::from_str(&to_json(answer).unwrap()).unwrap();
    serde_json::from_value(json.pointer(at).unwrap().clone()).unwrap()
}

/// A page or a screen as a person reads it: words and figures, one blank apart.
fn read(text: &str) -> String {
    let mut words = String::new();
    let mut in_tag = false;
    for c in text.chars() {
        match c {
            '<' => in_tag = true,
            '>' if in_tag => {
                in_tag = false;
                words.push(' ');
            }
            c if !in_tag => words.push(c),
            _ => {}
        }
    }
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What page and terminal must say of a fit, word for word.
fn assert_said(text: &str, fit: &Identification, names: [&str; 3], what: &str) {
    let text = read(text);
    let [rms, repeatability, held_out] = names;
    let unit = left_out(fit.holdout_unit);
    let mut expected = vec![
        format!("{rms} {}", um(fit.rms_um)),
        format!("{repeatability} {}", fit.noise_um.map_or("".into(), um)).trim().to_owned(),
    ];
    let bare = text.replace(['(', ')'], "");
    let held_out = format!("{held_out} {} {unit}", um_or_dash(fit.holdout_rms_um));
    assert!(bare.contains(&held_out), "{what} lacks \"{held_out}\": {bare}");
    expected.extend(fit.parameters.iter().map(|p| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        format!("{} {value} {u}", p.name)
    }));
    for figure in expected {
        assert!(text.contains(&read(&figure)), "{what} lacks \"{figure}\": {text}");
    }
}

/// The figures of a model from everybody who prints them; and the diagnosis.
fn check(fit: &Fit, what: &str) -> Diagnosed {
    let answer = fit.results();
    let figures = Figures::of_fit(&answer);
    assert!(figures.holdout_um.is_some() && !figures.parameters.is_empty(), "{what}: {figures:?}");
    let same = |other: &Figures, who: &str| figures.assert_same(other, &format!("{what}, {who}"));
    let diagnosed = fit.diagnose().unwrap();
    same(&Figures::of_residual(&diagnosed.results(), &figures), "residual of the diagnosis");
    let compared = diagnosed.compare();
    same(&Figures::of_fit(&compared.results().identification), "comparison");
    same(&Figures::of_fit(&in_json(&answer, "")), "JSON of the fit");
    same(&Figures::of_fit(&in_json(&compared.results(), "/identification")), "JSON of the comparison");
    let diagnosis = to_json(&diagnosed.results()).unwrap();
    let diagnosis: Diagnosis = serde_json::from_str(&diagnosis).unwrap();
    same(&Figures::of_residual(&diagnosis, &figures), "JSON of the diagnosis");
    assert_said(
        &fit.summary(),
        &answer,
        ["residual", "repeatability", "held-out"],
        &format!("{what}, screen"),
    );
    let names = ["Residual", "Repeatability", "Held-out error"];
    assert_said(&compared.page(), &answer, names, &format!("{what}, page"));
    let residual = format!("Residual {} rms", um(answer.rms_um));
    assert!(diagnosed.summary().contains(&residual), "{what}: {}", diagnosed.summary());
    diagnosed
}

fn check_step(before: &Diagnosed, step: &Step, what: &str) {
    let after = Figures::of_fit(&step.fit().results());
    let diagnosis = before.results();
    let added = in_json(&step.results("machine.model.toml"), "/identification");
    after.assert_same(&Figures::of_fit(&added), &format!("{what}, JSON of what was added"));
    after.assert_same(&Figures::of_candidate(&diagnosis, &after), &format!("{what}, candidate"));
    let again = step.fit().experiment().fit(step.model()).unwrap();
    after.assert_same(&Figures::of_fit(&again.results()), &format!("{what}, fit of the new model"));
    // The model file keeps four decimals; the row of the first entry has them all.
    let row = step.entries()[0].ladder.as_ref().unwrap();
    after.assert_same(&Figures::of_row(row, true, &after), &format!("{what}, ladder after"));
    let without = Figures::of_fit(&step.before().results());
    without.assert_same(&Figures::of_residual(&diagnosis, &without), &format!("{what}, fit before"));
    without.assert_same(&Figures::of_row(row, false, &without), &format!("{what}, ladder before"));
    let ladder = step.ladder();
    let (_, written) = ladder.added().next_back().unwrap();
    assert_eq!(um(written.error_after_um), um(after.rms_um), "{what}, ladder as written");
    let rung = read(&step.summary());
    let shown = format!(
        "+ {} {} {}",
        step.effect(),
        um(written.error_after_um),
        um_or_dash(written.holdout_after_um)
    );
    assert!(rung.contains(&shown), "{what}: {shown} in {rung}");
}

/// What is said of all that was found together is what adding all of it gives; `false` where one was found.
fn check_together(diagnosed: &Diagnosed, first: &Step, what: &str) -> bool {
    let answer = diagnosed.results();
    let Some((found, together)) = answer.found_together() else { return false };
    let all = found[1..].iter().fold(first.clone(), |step, one| step.add(&one.effect).unwrap());
    let fit = all.fit().results();
    // Shape numbers are refined from where each fit begins: to a thousandth.
    let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-3 * a, "{what}, together: {a} and {b}");
    same(together.rms_um_after, fit.rms_um);
    same(together.holdout_rms_um_after.unwrap(), fit.holdout_rms_um.unwrap());
    for own in &together.parameters {
        let is_shape =
            |shape: &trunnion_results::Shape| shape.effect == own.effect && shape.names.contains(&own.name);
        if let Some(fitted) = fit.parameters.iter().find(|p| p.effect == own.effect && p.name == own.name) {
            let [u, own_u] = [fitted.u, own.u].map(Option::unwrap);
            same(u, own_u);
            let [value, own_value] = [fitted.value, own.value].map(Option::unwrap);
            assert!((value - own_value).abs() <= 0.05 * u, "{what}, together: {own_value} and {value} ± {u}");
        } else {
            assert!(
                fit.shapes.iter().any(is_shape),
                "{what}: {} of {} is not in the model",
                own.name,
                own.effect
            );
        }
    }
    true
}

#[test]
fn every_surface_gives_the_same_figures() {
    let (mut added, mut together) = (0, 0);
    for (name, experiment) in recordings() {
        let fit = experiment.fit(&experiment.base_model()).unwrap();
        let diagnosed = check(&fit, &name);
        let Some(candidate) = diagnosed.results().candidates.into_iter().next() else { continue };
        let step = diagnosed.add(&candidate.effect).unwrap().dated("2026-01-01").unwrap();
        check_step(&diagnosed, &step, &format!("{name} + {}", candidate.effect));
        check(step.fit(), &format!("{name} with {}", candidate.effect));
        together += usize::from(check_together(&diagnosed, &step, &name));
        added += 1;
    }
    assert!(together > 0, "no recording has two effects");
    assert!(added >= 3, "only {added} recordings have a candidate");
}
