//! The items of the adapter, in the words of the standard (MTConnect 2.2): `config/mtconnect/trunnion.xml` describes them for an agent.

use crate::plant::PlantView;
use std::collections::BTreeMap;
use trunnion::results::{Condition, CycleState, LocationError, Presence};
use trunnion_core::convert::mm_from_um;

/// What follows the name of each item on its line.
pub type Items = BTreeMap<&'static str, String>;

const UNAVAILABLE: &str = "UNAVAILABLE";

/// Every item as it is now.
pub fn items(view: &PlantView) -> Items {
    if view.status.state == Presence::Offline {
        return gone();
    }
    let cycle = view.status.cycle.clone().unwrap_or_default();
    let run = cycle.run.as_deref().unwrap_or_default();
    BTreeMap::from([
        ("avail", "AVAILABLE".into()),
        ("system", condition(view)),
        ("execution", execution(cycle.state).into()),
        ("program", if run.is_empty() { UNAVAILABLE.into() } else { plain(run) }),
        ("verdict", verdict(view)),
        ("errors", measured(view)),
    ])
}

/// Of a service that is not there.
pub fn gone() -> Items {
    let unavailable = |item| (item, UNAVAILABLE.to_owned());
    let message = ("verdict", format!("|{UNAVAILABLE}"));
    ["avail", "execution", "program", "errors"]
        .map(unavailable)
        .into_iter()
        .chain([message, ("system", format!("{UNAVAILABLE}||||"))])
        .collect()
}

/// Of the category CONDITION: level, code, severity, qualifier, text.
fn condition(view: &PlantView) -> String {
    let level = match view.status.health.as_ref().map(|health| health.state).unwrap_or_default() {
        Condition::Good => "NORMAL",
        Condition::Limited => "WARNING",
        Condition::Failing => "FAULT",
    };
    let code = if level == "NORMAL" { "" } else { "health" };
    format!("{level}|{code}|||{}", plain(&view.why()))
}

fn execution(state: CycleState) -> &'static str {
    match state {
        CycleState::Offline => "UNAVAILABLE",
        CycleState::Ready | CycleState::Refused => "READY",
        CycleState::Measuring => "ACTIVE",
        CycleState::Analysing | CycleState::Done => "PROGRAM_COMPLETED",
        CycleState::Failed => "STOPPED",
    }
}

/// A MESSAGE: code and text.
fn verdict(view: &PlantView) -> String {
    match &view.result {
        Some(result) => format!("{}|{}", result.verdict.as_str(), plain(&view.found())),
        None => format!("|{UNAVAILABLE}"),
    }
}

/// FEATURE_MEASUREMENT, a table: a row for each location error that has a value. The agent forgets the rows of the run before.
fn measured(view: &PlantView) -> String {
    let errors =
        view.result.as_ref().and_then(|result| Some((&result.run, result.location_errors.as_ref()?)));
    let Some((run, errors)) = errors else { return UNAVAILABLE.into() };
    let rows: Vec<String> = errors.values.iter().filter_map(|error| row(run, error)).collect();
    if rows.is_empty() { UNAVAILABLE.into() } else { format!(":MANUAL {}", rows.join(" ")) }
}

fn row(run: &str, error: &LocationError) -> Option<String> {
    // Micrometres are no unit of the standard.
    let (kind, unit, per_unit): (_, _, fn(f64) -> f64) = match error.unit.as_str() {
        "um" => ("LENGTH", "MILLIMETER", mm_from_um),
        "urad" => ("ANGLE", "MICRO_RADIAN", |urad| urad),
        _ => return None,
    };
    let mut cells = vec![
        format!("MEASUREMENT_ID='{}'", plain(run).replace('\'', "")),
        format!("MEASUREMENT_TYPE={kind}"),
        format!("MEASUREMENT_VALUE={}", per_unit(error.value?)),
        format!("MEASUREMENT_UNITS={unit}"),
    ];
    if let Some(u) = error.u {
        cells.extend([format!("UNCERTAINTY={}", per_unit(u)), "UNCERTAINTY_TYPE=COMBINED".into()]);
    }
    Some(format!("{}={{{}}}", error.symbol, cells.join(" ")))
}

/// A text on its line: nothing in it begins another cell or line.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c == '|' || c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Board;
    use serde_json::json;

    #[test]
    fn items_hold_state_health_verdict_and_errors() {
        let board = Board::default();
        assert_eq!(items(&PlantView::of(&board)), gone());
        board.set("status", &json!({ "state": "online", "reason": null, "devices": {}, "chosen": null,
            "cycle": { "state": "measuring", "run": "r-test-1" },
            "health": { "state": "limited", "parts": { "disk": { "state": "limited", "why": "3 GB | left\n" } } } }));
        let items = items(&PlantView::of(&board));
        let found = |item: &str| items[item].as_str();
        assert_eq!(
            (found("avail"), found("execution"), found("program")),
            ("AVAILABLE", "ACTIVE", "r-test-1")
        );
        assert_eq!(found("system"), "WARNING|health|||disk: 3 GB   left ");
        assert_eq!((found("verdict"), found("errors")), ("|UNAVAILABLE", "UNAVAILABLE"));
    }

    #[test]
    fn lengths_are_millimetres_and_what_has_no_value_has_no_row() {
        let error = |unit: &str, value| LocationError {
            symbol: "EX0C".into(),
            unit: unit.into(),
            value,
            u: Some(0.5),
            ..LocationError::default()
        };
        let length = row("it's|1", &error("um", Some(-12.5))).unwrap_or_default();
        assert_eq!(
            length,
            "EX0C={MEASUREMENT_ID='its 1' MEASUREMENT_TYPE=LENGTH MEASUREMENT_VALUE=-0.0125 \
             MEASUREMENT_UNITS=MILLIMETER UNCERTAINTY=0.0005 UNCERTAINTY_TYPE=COMBINED}"
        );
        assert!(
            row("1", &error("urad", Some(7.0)))
                .is_some_and(|row| row.contains("VALUE=7 MEASUREMENT_UNITS=MICRO_RADIAN"))
        );
        assert_eq!((row("1", &error("um", None)), row("1", &error("1", Some(1.0)))), (None, None));
    }
}
