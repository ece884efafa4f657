//! What of the newest run lies outside the limits of the runs before it.

use trunnion::history::{alarms, of_found};
use trunnion::results::{AlarmsNow, Parameter, RunFound, RunLine, Verdict};

/// Runs of one machine, of which EB0C has these values, µrad, each ± 0.5.
fn lines(values: &[f64]) -> Vec<RunLine> {
    let line = |(k, value): (usize, &f64)| {
        let error = Parameter {
            name: "EB0C".into(),
            unit: "urad".into(),
            value: Some(*value),
            u: Some(0.5),
            observable: true,
            ..Parameter::default()
        };
        let found = RunFound {
            verdict: Verdict::NoiseFloor,
            rms_um: 0.3 + 0.01 * (k % 3) as f64,
            location_errors: vec![error],
            ..RunFound::default()
        };
        RunLine {
            name: format!("run-{k}"),
            machine: "m".into(),
            began_s: Some(86_400 * k as i64),
            found: Some(found),
            ..RunLine::default()
        }
    };
    values.iter().enumerate().map(line).collect()
}

fn of(values: &[f64]) -> AlarmsNow {
    alarms(&of_found(&lines(values), &[]))
}

#[test]
fn a_value_outside_its_limits_is_named_with_them_and_with_the_run_since_which_it_is() {
    let usual = [5.0, 5.4, 5.8, 5.2, 5.6, 5.0, 5.4, 5.8];
    assert_eq!(of(&[]), AlarmsNow::default());
    assert_eq!(of(&usual[..2]), AlarmsNow { run: Some("run-1".into()), ..AlarmsNow::default() });
    let quiet = of(&usual);
    assert_eq!((quiet.watched, quiet.alarms.len()), (2, 0), "{quiet:?}");

    let changed = of(&[&usual[..], &[25.0, 25.4]].concat());
    assert_eq!((changed.run.as_deref(), changed.watched), (Some("run-9"), 2));
    let [alarm] = &changed.alarms[..] else { panic!("{changed:?}") };
    assert_eq!((alarm.name.as_str(), alarm.unit.as_str(), alarm.value), ("EB0C", "urad", 25.4));
    assert_eq!(alarm.since, "run-8", "it stays changed");
    assert!((alarm.mean - 5.4).abs() < 1e-9 && alarm.low < 5.0 && alarm.high > 5.8, "{alarm:?}");
    assert!(alarm.high < 25.0 && alarm.words.contains("axis C"), "{alarm:?}");
}

/// Answers of older versions know the first effect only.
#[test]
fn a_run_of_the_list_shows_all_that_was_found_together() {
    let mut lines = lines(&[5.0, 5.4]);
    for (line, named) in lines.iter_mut().zip([&["thermal-expansion", "thermal-drift"][..], &[]]) {
        let found = line.found.as_mut().unwrap();
        found.candidate = Some("thermal-expansion".into());
        found.named = named.iter().map(ToString::to_string).collect();
    }
    let shown: Vec<_> = of_found(&lines, &[]).runs.into_iter().map(|run| run.candidate.unwrap()).collect();
    assert_eq!(shown, ["thermal-expansion; thermal-drift", "thermal-expansion"]);
}
