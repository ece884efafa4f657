//! A cycle that is not whole enough is not judged; what is planned, read and missing is said on every surface.

use std::path::PathBuf;
use trunnion::cycles::{Cycle, Pace, Run, RunKind};
use trunnion::results::{Complete, Missing, Question, Verdict};
use trunnion_core::{Lacks, Point, Quality, State};
use trunnion_machine::shipped;

const STATIC: &str = include_str!("../../../../config/cycles/demo-static.toml");
const CIRCLE: &str = include_str!("../../../../config/cycles/circle-xy.toml");
const CONE: &str = include_str!("../../../../config/cycles/bk4-cone.toml");
const SWEEP: &str = include_str!("../../../../config/cycles/demo-sweep-c.toml");

/// Three positions of B, twelve of C, both ways: 72 poses of two setups each.
fn seventy_two() -> String {
    STATIC.replacen("step_deg = 30", "step_deg = 90", 1)
}

/// 0.5 µm of scatter that is the same in every run of the test, mm.
fn scatter_mm(k: usize, component: usize) -> f64 {
    let x = (12.9898 * k as f64 + 78.233 * component as f64).sin() * 43_758.545_3;
    (x - x.floor() - 0.5) * 1.7e-3
}

/// A recording of a cycle in a folder of its own, each planned state with the quality that `fate` gives it; `None` is not there.
struct Recorded {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl Recorded {
    fn new(cycle_text: &str, fate: impl Fn(usize, &State) -> Option<Quality>) -> Self {
        Self::of_setups(cycle_text, usize::MAX, fate)
    }

    /// With so many setups of the cycle at most.
    fn of_setups(cycle_text: &str, most: usize, fate: impl Fn(usize, &State) -> Option<Quality>) -> Self {
        let mut cycle = Cycle::parse("c.toml", cycle_text).unwrap();
        let machine = shipped::machine(&cycle.machine).unwrap();
        let states = cycle.visits(&machine, &Pace::default()).unwrap().states;
        let point = |(k, state): (usize, &State)| {
            let quality = fate(k, state)?;
            let value = |component| match quality {
                Quality::NoReading(_) => f64::NAN,
                _ => scatter_mm(k, component),
            };
            let reading_mm = [value(0), value(1), value(2)];
            Some(Point { state: state.clone(), reading_mm, spread_mm: [0.0; 3], samples: 9, quality })
        };
        let points =
            states.iter().enumerate().filter(|(_, state)| state.setup < most).filter_map(point).collect();
        cycle.setups.truncate(most);
        let kind = cycle.run_kind();
        let run = Run { name: "r".into(), machine, kind, setups: cycle.setups, channels: vec![], points };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.mcap");
        let machine_text = trunnion::files::machine_text(&run.machine.name).unwrap();
        trunnion::tables::record(&path, &run, &machine_text, cycle_text, &[]).unwrap();
        Self { _folder: folder, path }
    }
}

fn only_first(n: usize) -> impl Fn(usize, &State) -> Option<Quality> {
    move |k, _| Some(if k < n { Quality::Good } else { Quality::NoReading(Lacks::Value) })
}

#[test]
fn a_recording_with_fewer_setups_than_its_cycle_is_read_without_a_plan() {
    let recorded = Recorded::of_setups(&seventy_two(), 1, |_, _| Some(Quality::Good));
    let experiment = trunnion::open(&recorded.path).unwrap();
    let fit = experiment.fit(&experiment.base_model()).unwrap();
    assert_eq!(fit.results().complete.planned, None);
    assert!(fit.results().points > 0);
}

#[test]
fn ten_of_72_poses_are_not_judged_and_every_surface_says_why() {
    let recorded = Recorded::new(&seventy_two(), only_first(10));
    let experiment = trunnion::open(&recorded.path).unwrap();
    let fit = experiment.fit(&experiment.base_model()).unwrap();
    let diagnosed = fit.diagnose().unwrap();
    let answer = diagnosed.results();
    assert_eq!((answer.verdict, answer.candidates.len()), (Verdict::NotJudged, 0));
    assert!(answer.why.contains("10 of 144 planned points"), "{}", answer.why);
    assert!(answer.why.contains("Repeat the cycle") && answer.why.contains("11 to 72"), "{}", answer.why);
    let check = experiment.check();
    assert_eq!(check.plausibility.last().map(|one| one.question), Some(Question::Whole));
    let of_setup = |setup: &str, count: usize, points: &str| Missing {
        run: "r".into(),
        setup: setup.into(),
        count,
        planned: 72,
        points: points.into(),
    };
    let missing = vec![of_setup("low", 62, "11 to 72"), of_setup("high", 72, "73 to 144")];
    assert_eq!(check.complete, Complete { planned: Some(144), read: 10, missing, ..Complete::default() });
    assert_eq!(answer.complete.missing, fit.results().complete.missing);
    let page = diagnosed.compare().page();
    for (surface, words) in [
        (fit.summary(), "62 of 72 points are missing"),
        (page.clone(), "62 of 72 points are missing"),
        (page, "a part of the cycle is missing"),
        (trunnion::report::check_text(&check), "10 of 144 planned points were read"),
    ] {
        assert!(
            surface.split_whitespace().collect::<Vec<_>>().join(" ").contains(words),
            "{words}:\n{surface}"
        );
    }
}

#[test]
fn a_cycle_that_lacks_little_is_judged_and_what_it_lacks_is_counted() {
    let fate = |k, _: &State| match k {
        3 | 7 => Some(Quality::NoReading(Lacks::Value)),
        9 => Some(Quality::Unsettled),
        _ => Some(Quality::Good),
    };
    let recorded = Recorded::new(&seventy_two(), fate);
    let check = trunnion::open(&recorded.path).unwrap().check();
    assert_eq!(check.plausibility, []);
    assert_eq!((check.complete.planned, check.complete.read), (Some(144), 141));
    assert_eq!(check.complete.missing[0].points, "4, 8");
    assert_eq!(check.complete.excluded[0].count, 1);
    assert!(check.complete.excluded[0].reason.contains("never settled"));

    let whole = Recorded::new(&seventy_two(), |_, _| Some(Quality::Good));
    let check = trunnion::open(&whole.path).unwrap().check();
    assert_eq!((check.plausibility.len(), check.complete.read), (0, 144));
    assert_eq!((check.complete.missing.len(), check.complete.excluded.len()), (0, 0));
}

#[test]
fn what_is_missing_decides_and_not_how_much() {
    let judged = |fate: &dyn Fn(usize, &State) -> Option<Quality>| {
        let recorded = Recorded::new(&seventy_two(), fate);
        let doubts = trunnion::open(&recorded.path).unwrap().check().plausibility;
        assert!(doubts.iter().all(|doubt| doubt.question == Question::Whole), "{doubts:?}");
        doubts.is_empty()
    };
    let keep = |kept: bool| Some(if kept { Quality::Good } else { Quality::NoReading(Lacks::Value) });
    // Half of the points of every place.
    assert!(judged(&|k, _| keep(k % 2 == 0)));
    // More than half, but of one position of B alone.
    assert!(!judged(&|k, state| keep(state.position[trunnion_core::Joint::B].abs() < 0.1 || k == 0)));
    // A killed program: the rest was never written.
    assert!(!judged(&|k, _| (k < 20).then_some(Quality::Good)));
}

#[test]
fn parts_of_one_cycle_are_judged_together() {
    let first = Recorded::new(&seventy_two(), only_first(60));
    let second = Recorded::new(&seventy_two(), |k, _| {
        Some(if k >= 60 { Quality::Good } else { Quality::NoReading(Lacks::Value) })
    });
    let check = |paths: &[&PathBuf]| trunnion::open_all(paths).unwrap().check();
    assert_eq!(check(&[&first.path]).plausibility.len(), 1);
    let both = check(&[&first.path, &second.path]);
    assert_eq!((both.plausibility.len(), both.complete.read, both.complete.planned), (0, 144, Some(288)));
}

#[test]
fn files_of_one_run_are_one_run_with_one_plan() {
    for (text, cut) in [(&seventy_two()[..], 60), (SWEEP, 100)] {
        let whole = trunnion::open(&Recorded::new(text, |_, _| Some(Quality::Good)).path).unwrap();
        let first = Recorded::new(text, |k, _| (k < cut).then_some(Quality::Good));
        let second = Recorded::new(text, |k, _| (k >= cut).then_some(Quality::Good));
        let files = vec![first.path.clone(), second.path.clone()];
        let run = trunnion::open_runs(&[files]).unwrap();
        assert_eq!((run.check().complete, run.plausibility()), (whole.check().complete, vec![]), "{text}");
        assert_eq!((run.runs().len(), run.points().points.len()), (1, whole.points().points.len()));
        // One mounting for each setup of the run, and none more for its second file.
        let of = |experiment: &trunnion::Experiment| {
            experiment.fit(&experiment.base_model()).unwrap().results().parameters.len()
        };
        assert_eq!(of(&run), of(&whole));
    }
}

#[test]
fn a_circle_and_a_cone_are_planned_along_their_curve_and_half_of_one_is_not_judged() {
    let turns = CIRCLE.replace("from_deg = 0\nto_deg = 360", "from_deg = -180\nto_deg = 540");
    assert_ne!(turns, CIRCLE);
    for (text, halves) in [(CIRCLE, 4), (&turns[..], 8), (CONE, 4)] {
        let whole = Recorded::new(text, |_, _| Some(Quality::Good));
        let check = trunnion::open(&whole.path).unwrap().check();
        let planned = check.complete.planned.unwrap();
        assert_eq!((check.complete.read, check.complete.missing.len()), (planned, 0), "{text}");
        assert_eq!(check.plausibility, [], "{text}");

        // Both directions of one half: the same way twice, and still only half of it.
        let part = planned / halves;
        let half = Recorded::new(text, |k, _| (k < part).then_some(Quality::Good));
        let experiment = trunnion::open(&half.path).unwrap();
        let check = experiment.check();
        // The last place of the part has a neighbour.
        assert!(check.complete.read.abs_diff(part) <= 2, "{} of {part}: {text}", check.complete.read);
        assert_eq!(missing(&check.complete), planned - check.complete.read, "{text}");
        let [doubt] = &check.plausibility[..] else { panic!("one doubt: {:?}", check.plausibility) };
        assert_eq!(doubt.question, Question::Whole);
        assert!(doubt.hypothesis.contains("Repeat the cycle"), "{}", doubt.hypothesis);
        let compared = experiment.fit(&experiment.base_model()).unwrap().compare();
        assert_eq!(compared.diagnosed().results().verdict, Verdict::NotJudged);
        assert!(!compared.page().contains("Nothing is missing"), "{text}");
    }
}

#[test]
fn the_directions_of_a_circle_are_planned_each() {
    let one_way = Recorded::new(CIRCLE, |_, state| {
        let turns = state.position[trunnion_core::Joint::X] * state.velocity[trunnion_core::Joint::Y]
            - state.position[trunnion_core::Joint::Y] * state.velocity[trunnion_core::Joint::X];
        (turns > 0.0).then_some(Quality::Good)
    });
    let check = trunnion::open(&one_way.path).unwrap().check();
    let planned = check.complete.planned.unwrap();
    assert_eq!((check.complete.read, missing(&check.complete)), (planned / 2, planned / 2));
}

/// At the ends of a pass the axes still speed up: the first place stands for the one before it, over the turn too.
#[test]
fn a_circle_that_begins_just_before_a_turn_is_whole_without_its_first_state() {
    for from_deg in [-1, 0, 90] {
        let ends = format!("from_deg = {from_deg}\nto_deg = {}", from_deg + 360);
        let text = CIRCLE.replace("from_deg = 0\nto_deg = 360", &ends);
        let begun = Recorded::new(&text, |k, _| (k > 0).then_some(Quality::Good));
        let check = trunnion::open(&begun.path).unwrap().check();
        assert_eq!(check.complete.missing, [], "from {from_deg}°");
    }
}

#[test]
fn on_the_fly_a_lost_pass_is_missing() {
    let whole = Recorded::new(SWEEP, |_, _| Some(Quality::Good));
    let check = trunnion::open(&whole.path).unwrap().check();
    let planned = check.complete.planned.unwrap();
    assert_eq!((check.complete.read, check.complete.missing.len()), (planned, 0));
    let without_back = Recorded::new(SWEEP, |_, state| {
        (state.velocity[trunnion_core::Joint::C] > 0.0).then_some(Quality::Good)
    });
    let check = trunnion::open(&without_back.path).unwrap().check();
    assert_eq!((check.complete.read, missing(&check.complete)), (planned / 2, planned / 2));
    assert_eq!(RunKind::OnTheFly, trunnion::open(&whole.path).unwrap().runs()[0].kind);
}

/// Points without a reading.
fn missing(complete: &Complete) -> usize {
    complete.missing.iter().map(|missing| missing.count).sum()
}
