//! Values of runs against the limits that the runs before them set (`trunnion_methods::control_chart`).

use trunnion_methods::control_chart::{Baseline, Limits};
use trunnion_results::sentences::error_in_words;
use trunnion_results::{HistoryRun, Parameter, Watched, WatchedPoint};

/// Name of the residual among the watched values.
const RMS: &str = Watched::RESIDUAL;

/// Watches the residual and every parameter of the runs; notes the alarms in them. The machine began to be what it is with the run at
/// each of `begins`: a correction or repair before it.
pub(super) fn watch(runs: &mut [HistoryRun], begins: &[usize]) -> Vec<Watched> {
    let mut names: Vec<(String, String)> = vec![(RMS.into(), "um".into())];
    for value in runs.iter().flat_map(|run| &run.values) {
        if !names.iter().any(|(name, _)| *name == value.name) {
            names.push((value.name.clone(), value.unit.clone()));
        }
    }
    let count = names.len();
    names.into_iter().map(|(name, unit)| one(runs, begins, count, name, unit)).collect()
}

fn one(runs: &mut [HistoryRun], begins: &[usize], count: usize, name: String, unit: String) -> Watched {
    // A residual is not negative, and neither is its lower limit.
    let least = if name == RMS { 0.0 } else { f64::NEG_INFINITY };
    let ends = |l: Limits| [l.mean, (l.mean - l.half_width).max(least), l.mean + l.half_width];
    let mut baseline = Baseline::default();
    let mut points = Vec::new();
    for (index, run) in runs.iter_mut().enumerate() {
        if begins.contains(&index) {
            baseline = Baseline::default();
        }
        let Some((value, u)) = value(run, &name) else { continue };
        let limits = baseline.limits(u, count);
        let alarm = limits.is_some_and(|limits| limits.alarm(value));
        match alarm {
            true => run.alarms.push(name.clone()),
            false => baseline.take(value, u),
        }
        let limits = limits.map(ends);
        points.push(WatchedPoint { run: index, value, u, limits, alarm });
    }
    let words = match name.as_str() {
        RMS => "Residual, rms".into(),
        name => error_in_words(name).unwrap_or_else(|| name.into()),
    };
    Watched { name, words, unit, points }
}

fn value(run: &HistoryRun, name: &str) -> Option<(f64, f64)> {
    if name == RMS {
        return Some((run.rms_um?, 0.0));
    }
    let Parameter { value, u, .. } = run.values.iter().find(|value| value.name == name)?;
    Some((((*value)?), (*u)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rms_um: f64, value: f64) -> HistoryRun {
        let value = Parameter {
            name: "EB0C".into(),
            unit: "urad".into(),
            value: Some(value),
            u: Some(0.5),
            observable: true,
            ..Parameter::default()
        };
        HistoryRun { rms_um: Some(rms_um), values: vec![value], ..HistoryRun::default() }
    }

    fn scattered(count: usize, about: f64) -> Vec<HistoryRun> {
        (0..count).map(|k| run(0.3 + 0.01 * (k % 3) as f64, about + 0.4 * (k % 5) as f64)).collect()
    }

    #[test]
    fn a_step_is_alarmed_about_in_the_value_that_stepped_until_the_baseline_begins_again() {
        let mut runs = scattered(12, 5.0);
        runs.extend(scattered(12, 25.0));
        let watched = watch(&mut runs, &[0]);
        assert_eq!(watched.iter().map(|w| w.name.as_str()).collect::<Vec<_>>(), ["rms", "EB0C"]);
        assert!(runs[..12].iter().all(|run| run.alarms.is_empty()), "an unchanged machine");
        assert!(runs[12..].iter().all(|run| run.alarms == ["EB0C"]), "it stays changed");
        assert_eq!(watched[1].points[1].limits, None, "two runs set the first limits");

        let mut again: Vec<_> = runs.iter().map(|run| HistoryRun { alarms: vec![], ..run.clone() }).collect();
        watch(&mut again, &[0, 12]);
        assert!(again.iter().all(|run| run.alarms.is_empty()), "a correction before the run 12");
    }
}
