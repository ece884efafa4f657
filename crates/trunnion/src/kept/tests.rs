//! Kept or worked out, an answer is the same; and never one of something else.

use super::*;
use crate::{Experiment, FormulaText, Model as Text};
use std::convert::Infallible;
use trunnion_engine::{self as engine, Diagnosis, KnownFits};
use trunnion_results::to_json_line;

/// These tests forget what the process worked out: one after the other.
static IN_TURN: Mutex<()> = Mutex::new(());

fn in_turn() -> MutexGuard<'static, ()> {
    IN_TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn forget() {
    *shelf() = Shelf::EMPTY;
}

fn open(set: &str) -> Experiment {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data"));
    crate::open(data.join(set).join("points.csv")).expect("committed points")
}

fn points() -> Experiment {
    open("points-gravity")
}

/// Every answer that starts from fits and diagnoses, in which every bit of a number shows.
fn answers(run: &Experiment) -> [String; 5] {
    let fit = run.fit(&run.base_model()).expect("they can be fitted");
    let compared = fit.compare().results();
    let tried = fit.try_effect("gravity-sag:B", &FormulaText::default()).expect("it can be tried");
    let step = fit.add("gravity-sag:B").and_then(|step| step.dated("2026-01-01")).expect("it can be added");
    let removed = step.fit().remove("gravity-sag:B", "2026-01-01", None).expect("it can be removed");
    let identification = format!("{:?}{:?}", fit.identification(), removed.identification());
    let json = |text: Result<String, _>| text.expect("it can be written");
    let lines = [to_json_line(&compared), to_json_line(&tried.results()), to_json_line(&step.results("m"))];
    let [compared, tried, added] = lines.map(json);
    [compared, tried, added, step.model().text().into(), identification]
}

/// What must not be worked out.
fn known<T: Serialize + DeserializeOwned + PartialEq>(run: &Experiment, kind: &str, model: &Text) -> T {
    let work = || -> Result<T, Infallible> { panic!("the {kind} is worked out again") };
    run.kept().answer(kind, (model.entries(), &()), work).unwrap_or_else(|never| match never {})
}

#[test]
fn an_answer_is_the_same_to_the_bit_kept_or_worked_out() {
    let _in_turn = in_turn();
    forget();
    let run = points();
    let first = answers(&run);
    let base = run.base_model();
    assert!(KnownFits::fit(&run, base.entries()).is_some(), "the fit is kept");
    let larger = run.fit(&base).and_then(|fit| fit.add("gravity-sag:B")).expect("it can be added");
    assert!(KnownFits::fit(&run, larger.model().entries()).is_some(), "so is that of what was tried");
    let diagnosis: Diagnosis = known(&run, "diagnosis", &base);
    assert_eq!(diagnosis.candidates[0].effect, "gravity-sag:B");
    let _: Diagnosis = known(&run, "diagnosis", larger.model());
    assert_eq!(answers(&run), first, "kept");
    assert_eq!(answers(&points()), first, "kept, for the same points opened again");
    forget();
    assert_eq!(answers(&points()), first, "worked out again");

    // Without what a diagnosis leaves behind: a fit that nobody shared anything with.
    forget();
    let alone = points();
    let of_file = alone.fit(larger.model()).expect("it can be fitted");
    assert_eq!(format!("{:?}", of_file.identification()), format!("{:?}", larger.fit().identification()));
}

#[test]
fn what_is_kept_of_some_points_and_a_model_is_of_no_others() {
    let _in_turn = in_turn();
    let run = points();
    let base = run.base_model();
    run.fit(&base).expect("they can be fitted");
    let knows = |points: &engine::Experiment, model: &Text| {
        let digest = OnceLock::new();
        Kept { points, digest: &digest }.fit(model.entries()).is_some()
    };
    assert!(knows(points().points(), &base), "the same points opened again");

    let with = |change: &dyn Fn(&mut trunnion_cycles::Run)| {
        let mut runs = run.runs().to_vec();
        change(&mut runs[0]);
        engine::Experiment::new(&runs).expect("usable points")
    };
    let ulp = |x: f64| f64::from_bits(x.to_bits() ^ 1);
    assert!(knows(&with(&|_| {}), &base), "the same points from elsewhere");
    for (what, other) in [
        ("a reading", with(&|run| run.points[7].reading_mm[1] = ulp(run.points[7].reading_mm[1]))),
        ("a temperature channel", with(&|run| run.channels.push("bed".into()))),
        ("the name", with(&|run| run.name.push('2'))),
        ("the ball", with(&|run| run.setups[0].ball_in_table_mm.x += 1e-9)),
        ("the machine", with(&|run| run.machine.name.push('2'))),
        ("readings behind a point", with(&|_| {}).of_means(&[2.0])),
    ] {
        assert!(!knows(&other, &base), "{what} differs");
    }

    let model = |text: &str| Text::parse("model", text.into()).expect("a model");
    assert!(knows(run.points(), &model(base.text())));
    for text in [
        format!("{}\n[[effect]]\nid = \"linear-scale:X\"\n", base.text()),
        base.text().replacen(
            "id = \"location-errors\"",
            "id = \"location-errors\"\nfixed = { EX0C = 1.0 }",
            1,
        ),
    ] {
        assert_ne!(text, base.text());
        assert!(!knows(run.points(), &model(&text)), "{text}");
    }
    let other: Result<Identification, ()> = run.kept().answer("diagnosis", (base.entries(), &()), || Err(()));
    assert_eq!(other, Err(()), "another kind of answer");
}

#[test]
fn a_number_that_json_does_not_hold_is_not_kept() {
    let _in_turn = in_turn();
    forget();
    let run = points();
    let (base, kept) = (run.base_model(), run.kept());
    let ask =
        |number: f64| kept.answer("number", (base.entries(), &()), || Ok::<_, Infallible>(vec![number]));
    assert!(ask(f64::NAN).is_ok_and(|numbers| numbers[0].is_nan()));
    assert_eq!(ask(0.1), Ok(vec![0.1]));
    assert_eq!(ask(0.2), Ok(vec![0.1]), "kept from the first time");
}

#[test]
fn an_expression_that_was_found_comes_back_whole() {
    let _in_turn = in_turn();
    forget();
    let added = || {
        let run = open("points-unnamed");
        let diagnosed =
            run.fit(&run.base_model()).and_then(|fit| fit.diagnose()).expect("they can be judged");
        let best = diagnosed.best().expect("it names something");
        assert!(best.starts_with("formula:"), "{best}");
        let step = diagnosed.add(&best).expect("it can be added");
        let answer = to_json_line(&diagnosed.results()).expect("it can be written");
        (answer, step.model().text().to_owned(), run)
    };
    let (answer, model, run) = added();
    let _: Diagnosis = known(&run, "diagnosis", &run.base_model());
    let (again, model_again, _) = added();
    assert_eq!((again, model_again), (answer, model));
}
