//! An answer that is undecided has the present poses as its next cycle where no other separates what is open.

use crate::common::points_run;
use trunnion_cycles::{Cycle, Run};
use trunnion_effects::Model;
use trunnion_engine::next_cycle::{Goal, Options, advise, next};
use trunnion_engine::{Diagnosis, Experiment, OpenEffect, Problem, Verdict, diagnose_problem};

fn advised(run: Run, open: &[&str]) -> (Experiment, Diagnosis) {
    let experiment = Experiment::new(&[run]).unwrap();
    let problem = Problem::new(&experiment, &Model::base("table-bc")).unwrap();
    let mut diagnosis = diagnose_problem(&problem, &Default::default()).unwrap();
    diagnosis.verdict = Verdict::Undecided;
    let effect = |id: &&str| OpenEffect { effect: id.to_string(), evidence: 0.9 };
    diagnosis.undecided = open.iter().map(effect).collect();
    diagnosis.next_cycle = None;
    advise(&problem, &mut diagnosis, &Options::default());
    (experiment, diagnosis)
}

#[test]
fn where_nothing_is_named_the_present_poses_are_measured_once_more() {
    let (experiment, diagnosis) = advised(points_run("points-nothing-hidden"), &[]);
    let next = diagnosis.next_cycle.unwrap();
    assert_eq!(next.suggestion, "Repeat this pass: the same poses once more.");
    let planned = next.cycle.expect("a cycle");
    assert!(planned.separates.is_empty() && planned.separation.is_none());
    let cycle = Cycle::parse("next.toml", &planned.file).unwrap();
    let poses = cycle.poses(experiment.machine()).unwrap();
    // By hand: two mountings of 5 minutes; each of 336 poses 1.5 s until it has settled, and its window; on the way the steps of C, 30° at 60°/s,
    // and between them those of B, as long at most.
    let at_rest_s = 2.0 * 300.0 + 336.0 * (1.5 + cycle.settle().expect("it stands").window_s);
    let least_min = at_rest_s / 60.0;
    assert!(
        (least_min..least_min + 336.0 * 0.5 * 1.2 / 60.0).contains(&planned.minutes),
        "{}",
        planned.minutes
    );
    assert_eq!(poses.len(), experiment.points.len(), "both directions, as they were measured");
    for pose in poses {
        let joints = experiment.machine().joints();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
        let visited = experiment.points.iter().any(|point| {
            joints.iter().all(|joint| near(point.state.position[*joint], pose.position[*joint]))
        });
        assert!(visited, "{pose:?}");
    }
}

/// What came with time comes with time once more: the one pose, read in both directions, would be over in a minute.
#[test]
fn a_machine_that_was_watched_at_rest_is_watched_as_long_once_more() {
    let mut run = points_run("points-nothing-hidden");
    let once = run.points[0].clone();
    run.points = (0..120)
        .map(|k| {
            let mut point = once.clone();
            point.state.time_s = Some(120.0 * f64::from(k));
            point.reading_mm = point.reading_mm.map(|mm| mm + 1e-4 * f64::from(k * 7 % 5));
            point
        })
        .collect();
    let (experiment, mut diagnosis) = advised(run, &[]);
    let advice = diagnosis.next_cycle.clone().unwrap();
    assert_eq!(
        advice.suggestion,
        "Watch another day of the same length: 120 readings at this pose in 3.97 h."
    );
    assert_eq!(advice.cycle, None);
    let problem = Problem::new(&experiment, &Model::base("table-bc")).unwrap();
    diagnosis.next_cycle = None;
    let plan = next(&problem, &diagnosis, &Options::default()).unwrap().expect("a plan");
    assert!(plan.answer.starts_with(&advice.suggestion), "{}", plan.answer);
    // What else could be measured is not this pose.
    assert!(plan.planned.is_none_or(|planned| !planned.name.ends_with("-again")));
}

#[test]
fn where_no_cycle_separates_what_is_open_the_advice_is_to_repeat() {
    let (_, diagnosis) = advised(points_run("points-nothing-hidden"), &["backlash:C", "setup-slip"]);
    let next = diagnosis.next_cycle.unwrap();
    assert!(next.suggestion.starts_with("Repeat this pass") && next.cycle.is_some(), "{next:?}");
}

/// Whatever is open: the plan of a diagnosis names the cycle that its advice names, and says the same first.
#[test]
fn a_plan_names_the_cycle_that_the_diagnosis_names() {
    let experiment = Experiment::new(&[points_run("points-nothing-hidden")]).unwrap();
    let problem = Problem::new(&experiment, &Model::base("table-bc")).unwrap();
    let found = diagnose_problem(&problem, &Default::default()).unwrap();
    let options = Options::default();
    for open in [&[][..], &["backlash:C", "setup-slip"], &["gravity-sag:B", "encoder-eccentricity:B"]] {
        let effect = |id: &&str| OpenEffect { effect: id.to_string(), evidence: 0.9 };
        let undecided = open.iter().map(effect).collect();
        let mut diagnosis =
            Diagnosis { verdict: Verdict::Undecided, undecided, next_cycle: None, ..found.clone() };
        let plan = next(&problem, &diagnosis, &options).unwrap().expect("a plan");
        advise(&problem, &mut diagnosis, &options);
        let advice = diagnosis.next_cycle.clone().expect("advice");
        assert!(
            plan.answer.starts_with(&advice.suggestion),
            "{open:?}: {} {}",
            plan.answer,
            advice.suggestion
        );
        assert_eq!(plan.planned, advice.cycle, "{open:?}");
        assert_eq!(plan.next.map(|cycle| cycle.to_text()), advice.cycle.map(|cycle| cycle.file), "{open:?}");
        assert_eq!(plan.goal == Goal::Repeat, advice.suggestion.starts_with("Repeat"), "{open:?}");
        // Asked once more, it is the same.
        let again = next(&problem, &diagnosis, &options).unwrap().expect("a plan");
        assert_eq!(again.answer, plan.answer, "{open:?}");
    }
}
