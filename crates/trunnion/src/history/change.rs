//! What changed between two runs, and which effect explains it.
//! d = x₂ − x₁,   u²(d) = u₁² + u₂²                                                    [GUM 5.1.2, independent runs]
//! Significant where |d| > t u(d), with one false one in a year of daily runs over all m parameters, as for the limits. A shape number that
//! was fitted, a time constant for example, is one of them.
//! An effect that the later run shows and the earlier does not is put into the model of both first: else the other parameters take
//! its place. Whether the parameters are all that changed is asked of the readings: the values of the earlier run predict the later.
//! Where they do not hold, the later run differs only if values of its own leave less:
//! n (r₁² − r₂²) > p t² (s₁² + s₂²),   t as for one parameter
//! n readings, r₁ rms that the values of the earlier run leave of them, r₂ that of its own, p parameters and shape numbers fitted, s₁ and s₂ rms of the two fits.
//! The left side is |J d|², J columns of the parameters: (s₁² + s₂²) χ²(p) for an unchanged machine, and χ²(p) exceeds p t² at most as often as
//! χ²(1) exceeds t². What both leave is no change of values: the readings scatter about the model.
//! Limits: u is what the runs know of themselves; what differs from day to day without being a change is in the control limits.

use crate::{Diagnosed, Error, Fit};
use trunnion_core::convert::mm_from_um;
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
    let asked = predicted.as_ref().map(|run| Asked {
        run,
        differs: is_beyond(run, &before, &fits[1]),
        before_um: before.rms_um,
    });
    change.words = words(&change, asked.as_ref(), is.verdict);
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

/// What the readings of the later run say of the values of the earlier.
struct Asked<'p> {
    run: &'p RunPrediction,
    /// True where they do not hold, and values of its own leave significantly less.
    differs: bool,
    /// What the model left in the earlier run, µm rms.
    before_um: f64,
}

/// True where values of the later run leave significantly less of its readings than those of the earlier.
fn is_beyond(run: &RunPrediction, before: &Identification, after: &Fit) -> bool {
    let fit = after.identification();
    let linear = fit.parameters.iter().filter(|p| p.observable() && !is_setting(&p.effect)).count();
    let shapes = fit.effects.iter().flat_map(|effect| &effect.shape_in_covariance).flatten().count();
    let fitted = linear + shapes;
    let t = t_beyond(1.0 / RUNS_PER_FALSE_ALARM, MANY);
    // Of all readings, as the prediction: an outlier of the fit is none of the scatter s.
    let moved = run.readings as f64 * mm_from_um(run.rms_um).powi(2) - fit.residual_mm.norm_squared();
    let scatter = mm_from_um(before.rms_um).powi(2) + fit.rms_mm.powi(2);
    moved > fitted as f64 * t * t * scatter
}

/// Parameters and shape numbers without those of the mounting.
fn of_machine(fit: &Identification) -> Vec<Parameter> {
    fit.listed().into_iter().filter(|p| !is_setting(&p.effect)).collect()
}

/// Every parameter that both determine, most changed first.
fn differences(before: &[Parameter], after: &[Parameter]) -> Vec<ChangedParameter> {
    let both = |after: &Parameter| {
        let before = before.iter().find(|before| before.is_comparable(after))?;
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

fn words(change: &RunChange, asked: Option<&Asked<'_>>, verdict: Verdict) -> Vec<String> {
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
    // What the earlier run does not determine predicts nothing either.
    let asked = asked.filter(|_| !change.parameters.is_empty());
    match asked {
        _ if change.parameters.is_empty() => words.push(none_in_common(from, to)),
        _ if !words.is_empty() => {}
        None => words.push("No value changed significantly.".into()),
        Some(asked) if asked.run.holds() => {
            words.push(format!("Nothing changed: the values of {from} predict {to}."));
        }
        Some(Asked { differs: true, .. }) => {
            words.push(format!("{to} differs from what the values of {from} predict."));
            words.push("No parameter of the model changed significantly: no effect explains it.".into());
        }
        Some(Asked { before_um, .. }) => {
            words.push(format!(
                "No value changed significantly: values of its own fit {to} hardly better than those of {from}."
            ));
            if let Some(after_um) = change.rms_with_new_um.filter(|after_um| after_um > before_um) {
                words.push(format!(
                    "The model leaves more in {to} than in {from}: {} rms, and {} there. Whether that is unusual, the limits of the residual say.",
                    um(after_um),
                    um(*before_um)
                ));
            }
        }
    }
    if verdict == Verdict::UnnamedStructure {
        words.push(format!("{to} shows something that the catalogue has no name for."));
    }
    if let Some((Asked { run, .. }, new_um)) = asked.zip(change.rms_with_new_um) {
        words.push(format!(
            "The values of {from} leave {} rms in {to} ({} of the readings in their 95 % band), values of its own {}.",
            um(run.rms_um),
            percent(run.inside_95_fraction),
            um(new_um)
        ));
    }
    words
}

/// Of two runs without a value that both determine in the same meaning.
pub(super) fn none_in_common(from: &str, to: &str) -> String {
    format!(
        "No value can be compared: {from} and {to} determine none in common. Repeat the cycle of {from} to see what changed."
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The committed points of one name, fitted with the base model.
    fn fitted(set: &str) -> Fit {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");
        let run = crate::open(format!("{data}/{set}/points.csv")).expect("committed points");
        run.fit(&run.base_model()).expect("it can be fitted")
    }

    #[test]
    fn another_machine_differs_from_what_the_values_of_the_first_predict_and_the_same_run_does_not() {
        let [first, other] = ["points-nothing-hidden", "points-gravity"].map(fitted);
        let differs = |before: &Fit, after: &Fit| {
            let run = predicted(&[before.clone(), after.clone()]).expect("a prediction").expect("a run");
            is_beyond(&run, &before.results(), after)
        };
        assert!(differs(&first, &other));
        assert!(!differs(&first, &first));
    }

    #[test]
    fn a_difference_that_no_value_explains_is_said() {
        let run = RunPrediction { rms_um: 5.0, inside_95_fraction: 0.4, ..RunPrediction::default() };
        let said = |parameters: Vec<ChangedParameter>| {
            let change = RunChange { from: "a".into(), to: "b".into(), parameters, ..RunChange::default() };
            words(&change, Some(&Asked { run: &run, differs: true, before_um: 1.0 }), Verdict::Undecided)
        };
        let shared = said(vec![ChangedParameter::default()]);
        assert!(shared[0].contains("b differs from what the values of a predict"), "{shared:?}");
        let [alone] = &said(Vec::new())[..] else { panic!("one sentence of runs that share no value") };
        assert!(alone.starts_with("No value can be compared: a and b determine none in common."), "{alone}");
    }
}
