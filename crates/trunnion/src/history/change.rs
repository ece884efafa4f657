//! What changed between two runs, and which effect explains it.
//! d = x₂ − x₁,   u²(d) = u₁² + u₂²                                                    [GUM 5.1.2, independent runs]
//! Significant where |d| > t u(d), with one false one in a year of daily runs over all m parameters, as for the limits.
//! An effect that the later run shows and the earlier does not is put into the model of both first: else the other parameters take
//! its place. Whether the parameters are all that changed is asked of the readings: the values of the earlier run predict the later.
//! Limits: u is what the runs know of themselves; what differs from day to day without being a change is in the control limits.

use crate::{Diagnosed, Error, Fit};
use trunnion_methods::control_chart::{RUNS_PER_FALSE_ALARM, t_beyond};
use trunnion_results::number::{decimals_of_u, percent, signed, um, unit_on_screen};
use trunnion_results::sentences::{effect_name, error_in_words, is_setting};
use trunnion_results::{
    ChangedParameter, HistoryRun, Identification, Parameter, RunChange, RunPrediction, Verdict,
};

/// As good as a normal distribution.
const MANY: usize = 1000;

/// What changed from one run to another, each diagnosed with the same model.
pub(super) fn change(
    (from, earlier): &(String, Diagnosed),
    (to, later): &(String, Diagnosed),
) -> Result<RunChange, Error> {
    let (was, is) = (earlier.results(), later.results());
    let known = |id: &String| was.set.contains(id) || was.candidates.iter().any(|c| c.effect == *id);
    let new = is.best().filter(|id| is.verdict == Verdict::MissingEffect && !known(id));
    let fits = match &new {
        Some(effect) => {
            let after = later.add(effect)?.fit().clone();
            [earlier.fit().experiment().fit_within_reach(after.model())?, after]
        }
        None => [earlier.fit().clone(), later.fit().clone()],
    };
    let [before, after] = [fits[0].results(), fits[1].results()];
    let mut change = RunChange {
        new_effects: new.into_iter().collect(),
        rms_with_new_um: Some(after.rms_um),
        from: from.clone(),
        to: to.clone(),
        parameters: differences(&of_machine(&before), &of_machine(&after)),
        ..RunChange::default()
    };
    let predicted = predicted(&fits)?;
    change.rms_with_old_um = predicted.as_ref().map(|run| run.rms_um);
    change.words = words(&change, predicted.as_ref(), is.verdict);
    Ok(change)
}

/// The same from values alone: nothing is asked of the readings.
pub(super) fn of_values(earlier: &HistoryRun, later: &HistoryRun) -> RunChange {
    let mut change = RunChange {
        from: earlier.run.clone(),
        to: later.run.clone(),
        parameters: between(earlier, later),
        rms_with_new_um: later.rms_um,
        ..RunChange::default()
    };
    change.words = words(&change, None, later.verdict);
    change
}

/// Every parameter of the machine that two runs determine, most changed first.
pub(super) fn between(earlier: &HistoryRun, later: &HistoryRun) -> Vec<ChangedParameter> {
    differences(&earlier.values, &later.values)
}

/// The values of the earlier run in the later.
fn predicted([before, after]: &[Fit; 2]) -> Result<Option<RunPrediction>, Error> {
    Ok(before.predict(after.experiment())?.runs.into_iter().next())
}

/// Parameters without those of the mounting.
fn of_machine(fit: &Identification) -> Vec<Parameter> {
    fit.parameters.iter().filter(|p| !is_setting(&p.effect)).cloned().collect()
}

/// Every parameter that both determine, most changed first.
fn differences(before: &[Parameter], after: &[Parameter]) -> Vec<ChangedParameter> {
    let both = |after: &Parameter| {
        // A parameter that stands for others does so in both, or it is not the same thing.
        let before = before.iter().find(|before| {
            (&before.effect, &before.name, &before.note) == (&after.effect, &after.name, &after.note)
        })?;
        let (value, other) = (after.value?, before.value?);
        let u = after.u?.hypot(before.u?);
        (u > 0.0).then(|| ChangedParameter {
            effect: after.effect.clone(),
            name: after.name.clone(),
            unit: after.unit.clone(),
            before: other,
            after: value,
            difference: value - other,
            u,
            changed: false,
        })
    };
    let mut found: Vec<ChangedParameter> = after.iter().filter_map(both).collect();
    let significant = t_beyond(1.0 / (RUNS_PER_FALSE_ALARM * found.len().max(1) as f64), MANY);
    for one in &mut found {
        one.changed = one.difference.abs() > significant * one.u;
    }
    found.sort_by(|a, b| (b.difference.abs() / b.u).total_cmp(&(a.difference.abs() / a.u)));
    found
}

fn words(change: &RunChange, predicted: Option<&RunPrediction>, verdict: Verdict) -> Vec<String> {
    let (from, to) = (&change.from, &change.to);
    let mut words = Vec::new();
    for effect in &change.new_effects {
        words.push(format!("New since {from}: {}.", effect_name(effect)));
    }
    let mut effects: Vec<&str> = Vec::new();
    let changed: Vec<&ChangedParameter> = change.parameters.iter().filter(|one| one.changed).collect();
    for one in &changed {
        if !effects.contains(&one.effect.as_str()) {
            effects.push(&one.effect);
        }
    }
    for effect in effects {
        let list: Vec<String> =
            changed.iter().filter(|one| one.effect == effect).map(|one| in_words(one)).collect();
        words.push(format!("Changed in {}: {}.", effect_name(effect), list.join("; ")));
    }
    match predicted.map(RunPrediction::holds) {
        _ if !words.is_empty() => {}
        None => words.push("No value changed significantly.".into()),
        Some(true) => words.push(format!("Nothing changed: the values of {from} predict {to}.")),
        Some(false) => {
            words.push(format!("{to} differs from what the values of {from} predict."));
            words.push("No parameter of the model changed significantly: no effect explains it.".into());
        }
    }
    if verdict == Verdict::UnnamedStructure {
        words.push(format!("{to} shows something that the catalogue has no name for."));
    }
    if let Some((run, new_um)) = predicted.zip(change.rms_with_new_um) {
        words.push(format!(
            "The values of {from} leave {} rms in {to} ({} of the readings in their 95 % band), values of its own {}.",
            um(run.rms_um),
            percent(run.inside_95_fraction),
            um(new_um)
        ));
    }
    words
}

/// `direction of axis B about X by +49.69 ± 0.30 µrad (EA0B, 167 u)`; behind ± stands the standard uncertainty.
fn in_words(one: &ChangedParameter) -> String {
    let decimals = decimals_of_u(one.u);
    let (name, symbol) = match error_in_words(&one.name) {
        Some(words) => (words, format!("{}, ", one.name)),
        None => (one.name.clone(), String::new()),
    };
    format!(
        "{name} by {} ± {:.decimals$} {} ({symbol}{:.0} u)",
        signed(one.difference, decimals),
        one.u,
        unit_on_screen(&one.unit),
        one.difference.abs() / one.u
    )
}
