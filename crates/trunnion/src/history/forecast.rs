//! What the next day is expected to show: the frozen values of the days before, with the band of `crate::prediction`.
//! x_next = x̂ ± √(u² + s²)    u of the mean of the days, s what differs from day to day           [docs/design/statistics.md §9]
//! An effect of the model that follows a temperature follows that of the next day; the band holds for temperatures like those measured.
//! A forecast is checked before it is given: the days before the last predict the last, which took no part in their fit.
//! Limits: as long as nobody changes the machine. A season that no day of these belongs to is not in it.

use super::keeper::{FORECAST, Keeper};
use crate::{Error, Experiment, Fit, Model, identity, open_runs};
use std::collections::BTreeMap;
use std::path::PathBuf;
use trunnion_core::chain;
use trunnion_effects::{FittedValue, Instance, Scene};
use trunnion_results::number::{percent, um};
use trunnion_results::sentences::{error_in_words, name_among};
use trunnion_results::{DayForecast, ForecastValue, HistoryRun, MachineHistory, RunPrediction};

/// Days on which was measured that a forecast needs: t of four degrees of freedom is 1.4 times that of many, of two it is 2.2 times.
const FEWEST_DAYS: usize = 5;
/// Days that are fitted together: the latest two working weeks. Older ones say less of tomorrow, and each costs a fit.
const MOST_DAYS: usize = 10;
const DAY_S: i64 = 86_400;

/// Indices of the runs that a forecast is made from, one a day and oldest first; or why they do not allow one. `since` is the first run
/// after a repair.
///
/// # Errors
/// A sentence that says what is missing.
pub fn days(history: &MachineHistory, since: usize) -> Result<Vec<usize>, String> {
    let corrected_s = history.corrections.iter().map(|correction| correction.at_s).max();
    let is_after =
        |run: &HistoryRun| corrected_s.is_none_or(|at_s| run.began_s.is_some_and(|began_s| began_s >= at_s));
    let counts = |run: &HistoryRun| run.rms_um.is_some() && is_after(run);
    let all: Vec<usize> = (since..history.runs.len()).filter(|&index| counts(&history.runs[index])).collect();
    if let Some(last) = all.last().map(|&index| &history.runs[index]).filter(|run| !run.alarms.is_empty()) {
        return Err(format!("{} is outside its control limits, so the machine is not what it was", last.run));
    }
    let unchanged: Vec<usize> =
        all.into_iter().filter(|&index| history.runs[index].alarms.is_empty()).collect();
    // The last run of each day: runs of one day differ by less than days do, and would be taken for days that hardly differ.
    let night_s = night_s(unchanged.iter().filter_map(|&index| history.runs[index].began_s));
    let day = |&index: &usize| Some(((history.runs[index].began_s? - night_s).div_euclid(DAY_S), index));
    let days: Vec<usize> =
        unchanged.iter().filter_map(day).collect::<BTreeMap<_, _>>().into_values().collect();
    if days.len() < FEWEST_DAYS {
        let measured = days.len();
        let after =
            if since > 0 || corrected_s.is_some() { " since the last correction or repair" } else { "" };
        let undated = unchanged.iter().any(|&index| history.runs[index].began_s.is_none());
        let undated = if undated { ", runs without a date not counted" } else { "" };
        return Err(format!("{measured} of {FEWEST_DAYS} days were measured{after}{undated}"));
    }
    Ok(days[days.len().saturating_sub(MOST_DAYS)..].to_vec())
}

/// Where a day ends, s after midnight in Greenwich: in the middle of the longest time of day in which no run began, the latest where
/// several are as long. By dates of Greenwich a shift in Tokyo would be two days.
fn night_s(began_s: impl Iterator<Item = i64>) -> i64 {
    let mut of_day_s: Vec<i64> = began_s.map(|began_s| began_s.rem_euclid(DAY_S)).collect();
    of_day_s.sort_unstable();
    of_day_s.extend(of_day_s.first().map(|first_s| first_s + DAY_S));
    let longest = of_day_s.windows(2).max_by_key(|pause| pause[1] - pause[0]);
    longest.map_or(0, |pause| i64::midpoint(pause[0], pause[1]))
}

/// Nothing is expected, and why.
pub fn without(why_not: String) -> DayForecast {
    let words = vec![format!("No forecast of the next day: {why_not}.")];
    DayForecast { why_not, words, ..DayForecast::default() }
}

/// The forecast from these runs, one a day and oldest first, each with the recordings that hold it; the base model without a model. A
/// forecast that fails is none, with the reason.
pub fn next_day(runs: &[Vec<PathBuf>], model: Option<&Model>, keeper: &mut Keeper<'_>) -> DayForecast {
    keeper
        .answer(("forecast", FORECAST), runs, model, || forecast(runs, model))
        .unwrap_or_else(|error| without(format!("it failed: {}", chain(&error))))
}

fn forecast(runs: &[Vec<PathBuf>], model: Option<&Model>) -> Result<DayForecast, Error> {
    let Some((last, before)) = runs.split_last().filter(|_| runs.len() >= FEWEST_DAYS) else {
        return Ok(without(format!("{} of {FEWEST_DAYS} days have samples", runs.len())));
    };
    let last = open_runs(std::slice::from_ref(last))?;
    let checked = fitted(&open_runs(before)?, model)?.predict(&last)?.runs.into_iter().next();
    let together = fitted(&open_runs(runs)?, model)?;
    let about = DayForecast {
        runs: together.experiment().runs().iter().map(|run| run.name.clone()).collect(),
        temperature_degc: temperatures(together.experiment()),
        checked,
        ..DayForecast::default()
    };
    if !together.between_runs().iter().any(Option::is_some) {
        let why = "the runs are of different cycles, so what differs from day to day is not known";
        return Ok(DayForecast { runs: about.runs, ..without(why.into()) });
    }
    if let Some(run) = about.checked.as_ref().filter(|run| !run.holds()) {
        let why_not = format!(
            "the runs before {} do not predict it: {} of its readings lie in the 95 % band",
            run.run,
            percent(run.inside_95_fraction)
        );
        let DayForecast { why_not, words, .. } = without(why_not);
        return Ok(DayForecast { why_not, words, ..about });
    }
    // Of the last run only the poses count.
    let band_95_um = together.predict(&last)?.runs.first().map(|run| run.band_95_um);
    let forecast = DayForecast { band_95_um, values: values(&together), ..about };
    Ok(DayForecast { words: words(&forecast, follows_temperature(&together)), ..forecast })
}

fn fitted(experiment: &Experiment, model: Option<&Model>) -> Result<Fit, Error> {
    let base = experiment.base_model();
    experiment.fit_within_reach(model.unwrap_or(&base))
}

fn values(together: &Fit) -> Vec<ForecastValue> {
    let all = together.values("").parameters;
    let name = |value: &FittedValue| {
        let others = all.iter().map(|other| (other.effect.as_str(), other.name.as_str()));
        name_among(&value.effect, &value.name, others)
    };
    let next = |value: FittedValue| {
        Some(ForecastValue {
            u: value.u?.hypot(value.between_runs.unwrap_or_default()),
            words: error_in_words(&value.name).unwrap_or_else(|| name(&value)),
            effect: value.effect,
            name: value.name,
            unit: value.unit,
            value: value.value,
        })
    };
    all.iter().cloned().filter_map(next).collect()
}

fn temperatures(together: &Experiment) -> Option<[f64; 2]> {
    let ranges: Vec<_> = together.runs().iter().flat_map(identity::temperatures).collect();
    let lowest = ranges.iter().map(|range| range.lowest_degc).min_by(f64::total_cmp)?;
    let highest = ranges.iter().map(|range| range.highest_degc).max_by(f64::total_cmp)?;
    Some([lowest, highest])
}

fn words(forecast: &DayForecast, follows_temperature: bool) -> Vec<String> {
    let mut words = Vec::new();
    if let Some(band_um) = forecast.band_95_um {
        let between = forecast.temperature_degc.map_or(String::new(), |[lowest, highest]| {
            format!(", at temperatures between {lowest:.1} and {highest:.1} °C")
        });
        words.push(format!(
            "The next day, if the machine stays as it is{between}: readings of the same cycle lie within ± {} of what the model of \
             these {} runs predicts (95 %).",
            um(band_um),
            forecast.runs.len()
        ));
    }
    if forecast.temperature_degc.is_none() {
        words.push("No temperature was recorded: the forecast holds for days like these.".into());
    } else if !follows_temperature {
        words.push(
            "No effect of the model follows a temperature: what it does from day to day widens the band like scatter.".into(),
        );
    }
    words.extend(forecast.checked.as_ref().map(|run: &RunPrediction| {
        format!(
            "Checked: the runs before {} predict it with an error of {} rms; {} of its readings lie in their 95 % band of ± {}.",
            run.run,
            um(run.rms_um),
            percent(run.inside_95_fraction),
            um(run.band_95_um)
        )
    }));
    words
}

/// True where an effect of the model is out of reach without the temperatures of these runs.
fn follows_temperature(together: &Fit) -> bool {
    let points = together.experiment().points();
    let without = Scene { channels: Vec::new(), ..points.scene.clone() };
    together.model().entries().effects.iter().any(|entry| {
        Instance::from_model_effect(entry, points.machine())
            .is_ok_and(|effect| effect.out_of_reach(&without).is_some())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_results::CorrectionEntered;

    fn runs(count: i64) -> MachineHistory {
        let run = |day: i64| HistoryRun {
            run: format!("day-{day}"),
            began_s: Some(day * DAY_S),
            rms_um: Some(0.3),
            ..HistoryRun::default()
        };
        MachineHistory { runs: (0..count).map(run).collect(), ..MachineHistory::default() }
    }

    /// Half past eight and four o'clock, wherever the machine stands: in Tokyo the morning is the evening before of Greenwich.
    #[test]
    fn runs_of_one_shift_are_one_day_in_every_time_zone() {
        for zone_h in -11..=12 {
            let mut two_a_day = runs(12);
            for (number, run) in (0..).zip(&mut two_a_day.runs) {
                let local_s = 5 * DAY_S + number / 2 * DAY_S + [30_600, 57_600][(number % 2) as usize];
                run.began_s = Some(local_s - zone_h * 3600);
            }
            assert_eq!(days(&two_a_day, 0).unwrap(), [1, 3, 5, 7, 9, 11], "{zone_h} h");
            // The last day has no afternoon yet.
            two_a_day.runs.pop();
            assert_eq!(days(&two_a_day, 0).unwrap(), [1, 3, 5, 7, 9, 10], "{zone_h} h");
        }
    }

    #[test]
    fn what_the_days_do_not_allow_is_said() {
        assert_eq!(days(&runs(4), 0).unwrap_err(), "4 of 5 days were measured");
        assert_eq!(days(&runs(6), 0).unwrap(), [0, 1, 2, 3, 4, 5]);
        assert_eq!(days(&runs(14), 0).unwrap(), (4..14).collect::<Vec<_>>(), "the latest ones");
        let said = days(&runs(8), 5).unwrap_err();
        assert_eq!(said, "3 of 5 days were measured since the last correction or repair");
        let corrected = MachineHistory {
            corrections: vec![CorrectionEntered { at_s: 6 * DAY_S - 1, ..CorrectionEntered::default() }],
            ..runs(8)
        };
        assert_eq!(
            days(&corrected, 0).unwrap_err(),
            "2 of 5 days were measured since the last correction or repair"
        );
        let mut four_a_day = runs(24);
        for (number, run) in (0..).zip(&mut four_a_day.runs) {
            run.began_s = Some(number * DAY_S / 4);
        }
        assert_eq!(days(&four_a_day, 0).unwrap(), [3, 7, 11, 15, 19, 23], "one run a day, its last");
        assert_eq!(
            days(&four_a_day, 8).unwrap_err(),
            "4 of 5 days were measured since the last correction or repair"
        );
        let mut changed = runs(8);
        changed.runs[7].alarms.push("EB0C".into());
        assert!(days(&changed, 0).unwrap_err().starts_with("day-7 is outside its control limits"));
        assert_eq!(days(&MachineHistory::default(), 0).unwrap_err(), "0 of 5 days were measured");
        let just_corrected = MachineHistory {
            corrections: vec![CorrectionEntered { at_s: 9 * DAY_S, ..CorrectionEntered::default() }],
            ..runs(8)
        };
        assert!(
            days(&just_corrected, 0).unwrap_err().starts_with("0 of 5 days"),
            "nothing was measured since"
        );
        assert_eq!(without("x".into()).words, ["No forecast of the next day: x."]);
    }
}
