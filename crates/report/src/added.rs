//! What was added to the model, said as long as it is in it: how far the error fell, how large it is, its likely cause, who added it.

use crate::number::{MISSING, value_and_u};
use trunnion_results::sentences::{about, effect_name, evidence_words, goes};
use trunnion_results::{Comparison, Identification, Ladder, LadderRow, LeftOut, Parameter, Trial};

/// Values closer to zero than so many standard uncertainties are no size, as of what moved in the ladder.
const CLEAR: f64 = 2.0;

/// How sure each effect is that was added: what it predicts that it has not seen, and its size in this fit.
pub(crate) fn sure(input: &Comparison) -> Vec<String> {
    let said = |(effect, row): (&str, &LadderRow)| {
        let sentences: Vec<String> =
            [held_out(row), size(&input.identification, effect)].into_iter().flatten().collect();
        (!sentences.is_empty()).then(|| format!("{}: {}", effect_name(effect), sentences.join(" ")))
    };
    input.ladder.added().filter_map(said).collect()
}

/// What each effect is that was added, and its likely cause.
pub(crate) fn causes(ladder: &Ladder) -> Vec<String> {
    ladder.added().flat_map(|(effect, _)| cause(effect)).collect()
}

fn cause(effect: &str) -> Vec<String> {
    match about(effect) {
        Some(about) => {
            vec![
                format!("{}: {}", effect_name(effect), about.explanation),
                format!("Likely cause: {}", about.cause),
            ]
        }
        // An expression says itself what it is.
        None => vec![effect_name(effect)],
    }
}

/// What was found before an effect was added: the effect and its cause, how sure that was, its rivals, who added it, and the fall.
pub(crate) fn as_found(trial: &Trial, row: &LadderRow) -> Vec<String> {
    let effect = trial.effect.as_str();
    let mut said = cause(effect);
    if !trial.expression.is_empty() {
        said.push(format!("The expression: {}", trial.expression));
    }
    said.extend(row.evidence.map(|evidence| format!("{}.", evidence_words(evidence))));
    said.extend(match row.confused_with.is_empty() {
        true => row.evidence.map(|_| "No other effect explained these data as well.".to_owned()),
        false => confounded(effect, &row.confused_with),
    });
    if !row.separate_by.is_empty() {
        said.push(format!("What separates them: {}", row.separate_by));
    }
    if !row.found_with.is_empty() {
        let names: Vec<String> = row.found_with.iter().map(|id| effect_name(id)).collect();
        said.push(format!("This was found while the model held {} too, taken out since.", names.join("; ")));
    }
    said.extend(match (&row.by, row.date.as_str()) {
        (_, "") => None,
        (Some(by), date) => Some(format!("Added by {by} on {date}.")),
        (None, date) => Some(format!("Added on {date}.")),
    });
    let [before, after] = [trial.rms_um.before, trial.rms_um.after].map(|um| um.unwrap_or(f64::NAN));
    said.push(format!("With it the residual {} rms.", goes(before, after)));
    said.extend(held_out(row));
    said
}

/// What the data do not distinguish from an effect.
pub(crate) fn confounded(effect: &str, rivals: &[String]) -> Option<String> {
    let names: Vec<_> = rivals.iter().map(|id| effect_name(id)).collect();
    (!names.is_empty())
        .then(|| format!("In these data {} is confounded with {}.", effect_name(effect), names.join("; ")))
}

/// Who added it, and when; a dash where nobody gave a name.
pub(crate) fn by_whom(row: &LadderRow) -> [String; 2] {
    let or_dash = |text: &str| if text.is_empty() { MISSING.into() } else { text.to_string() };
    [or_dash(row.by.as_deref().unwrap_or_default()), or_dash(&row.date)]
}

fn held_out(row: &LadderRow) -> Option<String> {
    let unit = LeftOut::named(row.holdout_unit.as_deref()?)?.plural();
    let (before, after) = row.holdout_before_um.zip(row.holdout_after_um)?;
    Some(format!("On {unit} left out of the fit the error {}.", goes(before, after)))
}

fn size(fit: &Identification, effect: &str) -> Option<String> {
    let is_clear = |p: &&Parameter| p.value.zip(p.u).is_some_and(|(value, u)| value.abs() > CLEAR * u);
    let own = fit.parameters.iter().filter(|p| p.effect == effect && p.observable).filter(is_clear);
    let said = own.map(|p| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        format!("{} = {value}, u = {u}", p.name)
    });
    let said = said.collect::<Vec<_>>().join("; ");
    (!said.is_empty()).then(|| format!("Its size: {said}."))
}
