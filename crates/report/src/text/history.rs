//! The runs of a machine as text: what changed first, then the runs, then the values with their limits.

use super::table::{columns, paragraph, titled};
use crate::number::{MISSING, justified, um_or_dash, unit_on_screen, value_and_u};
use trunnion_results::sentences::{name_among, verdict_in_short};
use trunnion_results::{ForecastValue, HistoryRun, MachineHistory, Watched};

/// The history of a machine.
pub fn history_text(history: &MachineHistory) -> String {
    let mut text = format!("{}\n\n", alarm_line(history));
    if let Some(change) = &history.change {
        text += &format!("What changed from {} to {}\n", change.from, change.to);
        text += &change.words.iter().map(|words| paragraph(words)).collect::<String>();
        text.push('\n');
    }
    if !history.why_no_change.is_empty() {
        text += &format!("What changed is not known\n{}\n", paragraph(&history.why_no_change));
    }
    for around in &history.around_corrections {
        text += "Before and after a correction\n";
        text += &around.words.iter().map(|words| paragraph(words)).collect::<String>();
        text.push('\n');
    }
    text += &format!("Machine {}", history.machine);
    // Without a run that can be compared there is no model.
    if !history.effects.is_empty() {
        text += &format!("; model: {}", history.effects.join(" + "));
    }
    text.push('\n');
    text += &runs(history);
    let limits: String = values(history);
    if !limits.is_empty() {
        text += "\nLast value against the limits that the runs before it set\n";
        text += &limits;
        text += "At most one false alarm in 365 runs over all of these values together.\n";
    }
    if let Some(next) = &history.forecast {
        text += "\nThe next day\n";
        text += &next.words.iter().map(|words| paragraph(words)).collect::<String>();
        text += &expected(&next.values);
    }
    history.notes.iter().fold(text, |text, note| text + note + "\n")
}

/// The answer in one line.
fn alarm_line(history: &MachineHistory) -> String {
    let Some(last) = history.runs.iter().rev().find(|run| run.rms_um.is_some()) else {
        return "No run of this machine can be compared".into();
    };
    let newest = || history.watched.iter().filter_map(|one| one.points.last());
    let has_limits = newest().any(|point| point.limits.is_some());
    let set_by = newest().filter(|point| point.has_wide_limits()).map(|point| point.set_by).min();
    match (last.alarms.as_slice(), set_by) {
        ([], Some(few)) => format!(
            "{}: every value is within its control limits, which are still wide: {few} runs set them",
            last.run
        ),
        ([], None) if has_limits => format!("{}: every value is within its control limits", last.run),
        ([], None) => format!("{}: there are no control limits yet, they need two runs before", last.run),
        (alarms, _) => {
            let title = |name: &String| {
                history.watched.iter().find(|one| one.name == *name).map_or(name.clone(), Watched::title)
            };
            let titles: Vec<String> = alarms.iter().map(title).collect();
            format!("{}: outside its control limits: {}", last.run, titles.join("; "))
        }
    }
}

fn runs(history: &MachineHistory) -> String {
    let mut rows =
        vec![["run", "began", "residual", "temperature", "alarms", "verdict"].map(String::from).to_vec()];
    let row = |run: &HistoryRun| {
        let verdict = match (run.trouble.as_str(), &run.candidate) {
            ("", Some(candidate)) => format!("{}: {candidate}", verdict_in_short(run.verdict)),
            ("", None) => verdict_in_short(run.verdict).into(),
            (trouble, _) => trouble.into(),
        };
        let or_dash = |text: &str| if text.is_empty() { MISSING.into() } else { text.to_string() };
        vec![
            run.run.clone(),
            or_dash(&run.began),
            um_or_dash(run.rms_um),
            run.temperature_degc.map_or(MISSING.into(), |degc| format!("{degc:.1} °C")),
            or_dash(&run.alarms.join(", ")),
            verdict,
        ]
    };
    rows.extend(history.runs.iter().map(row));
    titled(&rows, &[2, 3])
}

/// Each value of the next day; nothing where nothing is expected.
fn expected(values: &[ForecastValue]) -> String {
    if values.is_empty() {
        return String::new();
    }
    let row = |one: &ForecastValue| {
        let (value, u) = value_and_u(Some(one.value), Some(one.u), &one.unit);
        let all = values.iter().map(|other| (other.effect.as_str(), other.name.as_str()));
        vec![name_among(&one.effect, &one.name, all), value, u]
    };
    let mut rows = vec![["expected", "", "u"].map(String::from).to_vec()];
    rows.extend(values.iter().map(row));
    columns(&rows, &[1, 2])
}

/// `−2.1 … 4.3 µm`, with the digits that its half width justifies.
fn interval([lower, upper]: [f64; 2], unit: &str) -> String {
    let half = (upper - lower) / 2.0;
    format!("{} … {} {unit}", justified(lower, half), justified(upper, half))
}

/// Each value of the last compared run.
fn values(history: &MachineHistory) -> String {
    let Some(last) = history.runs.iter().rposition(|run| run.rms_um.is_some()) else { return String::new() };
    let row = |one: &Watched| {
        let point = one.points.last().filter(|point| point.run == last)?;
        let (value, u) = value_and_u(Some(point.value), Some(point.u), &one.unit);
        let unit = unit_on_screen(&one.unit);
        let limits = point.limits.map_or(MISSING.into(), |[_, lower, upper]| interval([lower, upper], &unit));
        let set_by = point.limits.map_or(MISSING.into(), |_| format!("{} runs", point.set_by));
        let alarm = if point.alarm { "outside" } else { "" };
        Some(vec![one.name.clone(), value, u, limits, set_by, alarm.to_string()])
    };
    let mut rows = vec![["value", "", "u", "limits", "set by", ""].map(String::from).to_vec()];
    rows.extend(history.watched.iter().filter_map(row));
    if rows.len() == 1 { String::new() } else { columns(&rows, &[1, 2]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_results::{DayForecast, WatchedPoint};

    #[test]
    fn the_values_of_the_next_day_are_printed_and_the_residual_has_no_symbol() {
        let value = ForecastValue {
            name: "EA0B".into(),
            unit: "urad".into(),
            value: 25.04,
            u: 0.62,
            ..ForecastValue::default()
        };
        let forecast = DayForecast {
            words: vec!["The next day, if the machine stays as it is.".into()],
            values: vec![value],
            ..DayForecast::default()
        };
        let run = HistoryRun {
            run: "friday".into(),
            rms_um: Some(0.9),
            alarms: vec![Watched::RESIDUAL.into()],
            ..HistoryRun::default()
        };
        let residual = Watched {
            name: Watched::RESIDUAL.into(),
            words: "residual, rms".into(),
            unit: "um".into(),
            ..Watched::default()
        };
        let history = MachineHistory {
            runs: vec![run],
            watched: vec![residual],
            forecast: Some(forecast),
            ..MachineHistory::default()
        };
        let text = history_text(&history);
        assert!(text.starts_with("friday: outside its control limits: residual, rms\n"), "{text}");
        let row = text.lines().find(|line| line.contains("EA0B")).unwrap_or_default();
        assert_eq!(row.split_whitespace().collect::<Vec<_>>(), ["EA0B", "25.04", "µrad", "0.62", "µrad"]);
    }

    #[test]
    fn limits_that_few_runs_set_are_no_all_clear() {
        let said = |set_by| {
            let point = WatchedPoint {
                value: 0.3,
                limits: Some([0.3, 0.0, 12465.0]),
                set_by,
                ..WatchedPoint::default()
            };
            let name = Watched::RESIDUAL.to_string();
            let residual = Watched { name, unit: "um".into(), points: vec![point], ..Watched::default() };
            let run = HistoryRun { run: "friday".into(), rms_um: Some(0.3), ..HistoryRun::default() };
            history_text(&MachineHistory {
                runs: vec![run],
                watched: vec![residual],
                ..MachineHistory::default()
            })
        };
        let few = said(2);
        assert!(
            few.starts_with(
                "friday: every value is within its control limits, which are still wide: 2 runs set them\n"
            ),
            "{few}"
        );
        assert!(few.contains("12465 µm  2 runs"), "{few}");
        assert!(said(20).starts_with("friday: every value is within its control limits\n"));
    }
}
