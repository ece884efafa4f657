//! Values of runs against the limits that the runs before them set (`trunnion_methods::control_chart`).

use trunnion_methods::control_chart::{Baseline, Limits};
use trunnion_results::sentences::{as_axes_stand, error_in_words, name_among};
use trunnion_results::{HistoryRun, Parameter, Watched, WatchedPoint};

/// Name of the residual among the watched values.
const RMS: &str = Watched::RESIDUAL;

/// Watches the residual and every parameter of the runs; notes the alarms in them. The machine began to be what it is with the run at
/// each of `begins`: a correction or repair before it.
pub(super) fn watch(runs: &mut [HistoryRun], begins: &[usize]) -> Vec<Watched> {
    let mut watched: Vec<Key> = vec![Key::Residual];
    for value in runs.iter().flat_map(|run| &run.values) {
        if !watched.iter().any(|key| key.is_of(value)) {
            watched.push(Key::Of(value.clone()));
        }
    }
    let names: Vec<String> = watched.iter().map(|key| key.name(&watched)).collect();
    watched.iter().zip(names).map(|(key, name)| one(runs, begins, watched.len(), key, name)).collect()
}

/// What is watched.
enum Key {
    Residual,
    /// What every run has that is comparable with this value of the first: parameters of two effects may have one name, and a value
    /// that contains errors of an axis at rest is not the one without them.
    Of(Parameter),
}

impl Key {
    fn is_of(&self, value: &Parameter) -> bool {
        matches!(self, Self::Of(first) if first.is_comparable(value))
    }

    /// Value and standard uncertainty.
    fn value(&self, run: &HistoryRun) -> Option<(f64, f64)> {
        match self {
            Self::Residual => Some((run.rms_um?, 0.0)),
            Self::Of(_) => {
                let Parameter { value, u, .. } = run.values.iter().find(|value| self.is_of(value))?;
                Some((((*value)?), (*u)?))
            }
        }
    }

    /// The name among all that is watched: with the effect where several have it, and with what a value stands for.
    fn name(&self, all: &[Self]) -> String {
        let Self::Of(first) = self else { return RMS.into() };
        let others = || all.iter().filter_map(|other| if let Self::Of(of) = other { Some(of) } else { None });
        let name =
            name_among(&first.effect, &first.name, others().map(|of| (of.effect.as_str(), of.name.as_str())));
        let is_twice =
            others().filter(|of| (&of.effect, &of.name) == (&first.effect, &first.name)).count() > 1;
        match as_axes_stand(&first.at_rest) {
            Some(words) => format!("{name}, {words}"),
            None if is_twice && !first.note.is_empty() => format!("{name}, {}", first.note),
            None => name,
        }
    }
}

fn one(runs: &mut [HistoryRun], begins: &[usize], count: usize, key: &Key, name: String) -> Watched {
    // A residual is not negative, and neither is its lower limit.
    let (least, effect, words, unit) = match key {
        Key::Residual => (0.0, String::new(), "residual, rms".into(), "um".into()),
        Key::Of(first) => {
            let words = error_in_words(&first.name).unwrap_or_else(|| name.clone());
            (f64::NEG_INFINITY, first.effect.clone(), words, first.unit.clone())
        }
    };
    let ends = |l: Limits| [l.mean, (l.mean - l.half_width).max(least), l.mean + l.half_width];
    let mut baseline = Baseline::default();
    let mut points = Vec::new();
    for (index, run) in runs.iter_mut().enumerate() {
        if begins.contains(&index) {
            baseline = Baseline::default();
        }
        let Some((value, u)) = key.value(run) else { continue };
        let limits = baseline.limits(u, count);
        let set_by = baseline.count();
        let alarm = limits.is_some_and(|limits| limits.alarm(value));
        match alarm {
            true => run.alarms.push(name.clone()),
            false => baseline.take(value, u),
        }
        let limits = limits.map(ends);
        points.push(WatchedPoint { run: index, value, u, limits, set_by, alarm });
    }
    Watched { name, effect, words, unit, points }
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

    /// The scales of two axes have one name; a jump of the one is not hidden by the other.
    #[test]
    fn values_of_two_effects_with_one_name_are_watched_each() {
        let scale = |effect: &str, value: f64| Parameter {
            effect: effect.into(),
            name: "scale".into(),
            unit: "um/m".into(),
            value: Some(value),
            u: Some(1.0),
            ..Parameter::default()
        };
        let day = |k: usize| HistoryRun {
            values: vec![
                scale("linear-scale:X", [3.0, 3.4, 2.8][k % 3]),
                scale("linear-scale:Z", if k < 6 { 0.2 * (k % 3) as f64 } else { 49.0 }),
            ],
            ..run(0.3 + 0.01 * (k % 3) as f64, 5.0 + 0.4 * (k % 5) as f64)
        };
        let mut runs: Vec<HistoryRun> = (0..8).map(day).collect();
        let watched = watch(&mut runs, &[0]);
        let names: Vec<&str> = watched.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["rms", "scale of linear-scale:X", "scale of linear-scale:Z"]);
        assert_eq!(watched[2].effect, "linear-scale:Z");
        assert!(runs[6..].iter().all(|run| run.alarms == ["scale of linear-scale:Z"]), "{runs:?}");
    }

    /// A sweep of C alone sees C as B stands; a cycle of both axes sees C itself.
    #[test]
    fn a_value_that_holds_errors_of_an_axis_at_rest_is_no_value_of_the_series_without_them() {
        let mut runs = scattered(8, 5.0);
        runs.push(run(0.3, 25.0));
        let swept = &mut runs[8].values[0];
        (swept.note, swept.at_rest) = ("contains EB0B, its axis at rest".into(), vec!["EB0B".into()]);
        let watched = watch(&mut runs, &[0]);
        let names: Vec<&str> = watched.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["rms", "EB0C", "EB0C, as B stands"]);
        assert_eq!(watched[2].title(), "direction of axis C about Y (EB0C, as B stands)");
        assert_eq!(watched[1].points.len(), 8, "{:?}", watched[1].points);
        assert!(runs[8].alarms.is_empty(), "{:?}", runs[8].alarms);
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
