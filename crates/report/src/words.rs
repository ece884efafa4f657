//! What a comparison and a trial come to, in sentences: shared by page and terminal. Each thing is said once.

mod frozen;
mod trial;

pub(crate) use frozen::frozen_headline;
pub use frozen::{differences, frozen_sentences, not_in_band};
pub use trial::trial_verdict;

use crate::added::causes;
use crate::number::{percent, plain, um, um_or_dash};
use trunnion_results::{
    AxisSpectrum, Candidate, Comparison, Diagnosis, FormulaProposal, Ladder, LeftOut, Parameter, Question,
    SpectrumWave, Together, Verdict,
};

pub use trunnion_results::sentences::*;

/// The answer in one line.
pub fn headline(input: &Comparison) -> String {
    let rms_um = input.identification.rms_um;
    let left = um(rms_um);
    if let Some(frozen) = &input.frozen {
        return frozen_headline(frozen).into();
    }
    let Some(diagnosis) = &input.diagnosis else {
        return match input.identification.noise_um {
            Some(noise_um) if rms_um > 1.25 * noise_um => {
                format!(
                    "Something is missing from the model: residual {left} rms, repeatability {}",
                    um(noise_um)
                )
            }
            Some(noise_um) => {
                format!("The model reaches the noise: residual {left} rms, repeatability {}", um(noise_um))
            }
            None => format!("The model leaves {left} rms; how much of it is noise is not known"),
        };
    };
    match (diagnosis.verdict, diagnosis.candidates.first()) {
        (Verdict::NoiseFloor, _) if input.ladder.added().next().is_none() => {
            "No effect is missing that these data can show".into()
        }
        (Verdict::NoiseFloor, _) => "The model now explains this machine down to the noise".into(),
        (Verdict::MissingEffect, Some(best)) => match diagnosis.found_together() {
            Some((found, _)) => format!("Missing from the model, together: {}", names(&found)),
            None => format!("Missing from the model: {}", effect_name(&best.effect)),
        },
        (Verdict::Undecided, _) => "These data cannot say whether an effect is missing".into(),
        (Verdict::NotJudged, _) if is_only_incomplete(input) => {
            "Not judged: a part of the cycle is missing".into()
        }
        (Verdict::NotJudged, _) if is_failed(input) => "Not judged: the diagnosis failed".into(),
        (Verdict::NotJudged, _) => "Not judged: these runs cannot be what they say they are".into(),
        _ => "Something that the catalogue has no name for is missing from the model".into(),
    }
}

/// What is wrong with the machine, for somebody who knows nothing of this program: sentences of one paragraph.
pub fn verdict(input: &Comparison) -> Vec<String> {
    let mut sentences: Vec<String> = input.frozen.iter().flat_map(frozen_sentences).collect();
    if let Some(diagnosis) = &input.diagnosis {
        match (diagnosis.verdict, diagnosis.candidates.first(), &diagnosis.formula) {
            (Verdict::NoiseFloor, ..) => sentences.extend(nothing_left(input, diagnosis)),
            (Verdict::MissingEffect, Some(best), _) => {
                sentences.extend(match diagnosis.found_together() {
                    Some((found, together)) => several(diagnosis, &found, together),
                    None => named(diagnosis, best),
                });
                sentences.extend(why(diagnosis));
            }
            (Verdict::Undecided | Verdict::NotJudged, ..) => sentences.extend(undecided(diagnosis)),
            (_, _, formula) => {
                sentences.push(format!(
                    "The readings differ from what the model predicts by {} rms ({}): \
                     part of this is significant, and no effect of the catalogue describes it.",
                    um(diagnosis.residual.rms_um),
                    repeatability(diagnosis.residual.noise_um, diagnosis.residual.noise_readings)
                ));
                sentences.extend(formula.as_ref().map(|formula| unnamed(diagnosis, formula)));
                sentences.extend(why(diagnosis));
            }
        }
    }
    let lead = if sentences.is_empty() { "" } else { "In addition, " };
    if is_judged(input) {
        sentences.extend(location_sentence(&input.identification.parameters, lead));
    }
    sentences.extend(doubts(&input.identification));
    sentences
}

fn why(diagnosis: &Diagnosis) -> Option<String> {
    Some(diagnosis.why.clone()).filter(|why| !why.is_empty())
}

pub(crate) fn is_only_incomplete(input: &Comparison) -> bool {
    let asked = &input.identification.plausibility;
    !asked.is_empty() && asked.iter().all(|one| one.question == Question::Whole)
}

/// False where the runs are not whole or cannot be what they say they are: no number of theirs is one of the machine.
fn is_judged(input: &Comparison) -> bool {
    let refused = input.diagnosis.as_ref().is_some_and(|d| d.verdict == Verdict::NotJudged);
    !refused && input.identification.plausibility.is_empty()
}

/// True where nothing is wrong with the runs and the diagnosis itself gave no answer.
pub(crate) fn is_failed(input: &Comparison) -> bool {
    let not_judged = input.diagnosis.as_ref().is_some_and(|d| d.verdict == Verdict::NotJudged);
    not_judged && input.identification.plausibility.is_empty()
}

fn undecided(diagnosis: &Diagnosis) -> Vec<String> {
    let next = diagnosis.next_cycle.as_ref().map(|next| next.suggestion.clone());
    [Some(diagnosis.why.clone()), next].into_iter().flatten().filter(|text| !text.is_empty()).collect()
}

fn nothing_left(input: &Comparison, diagnosis: &Diagnosis) -> Vec<String> {
    let mut sentences = Vec::new();
    let added = input.ladder.added().count();
    if let Some((_, first)) = input.ladder.added().next() {
        sentences.push(match added {
            1 => "One effect was found and put into the model.".into(),
            n => format!("{n} effects were found and put into the model."),
        });
        sentences.extend(causes(&input.ladder));
        sentences.push(format!(
            "With {} the residual falls from {} to {} rms.",
            if added == 1 { "it" } else { "them" },
            um(first.error_before_um),
            um(input.identification.rms_um)
        ));
    }
    sentences.push(format!(
        "The model leaves {} rms ({}); nothing in it points at a further cause.",
        um(diagnosis.residual.rms_um),
        repeatability(diagnosis.residual.noise_um, diagnosis.residual.noise_readings)
    ));
    sentences.extend(noticeable(diagnosis));
    sentences.extend(remaining_pattern(diagnosis));
    sentences.extend(why(diagnosis));
    sentences
}

/// Why no effect is listed.
pub fn nothing_named<'d>(input: &Comparison, diagnosis: &'d Diagnosis) -> &'d str {
    match diagnosis.verdict {
        Verdict::Undecided => &diagnosis.why,
        Verdict::NotJudged if is_failed(input) => "No effect was judged, because the diagnosis failed.",
        Verdict::NotJudged => "No effect was judged, because the runs are not plausible or not whole.",
        Verdict::NoiseFloor if input.ladder.added().next().is_some() => {
            "Nothing further is missing that these data can show: what was found is in the model."
        }
        _ => "No effect explains the residual significantly better than noise does.",
    }
}

/// Where nothing stands out, or nothing was looked for.
pub fn no_place(input: &Comparison) -> &'static str {
    match &input.diagnosis {
        _ if is_failed(input) => "Not looked for, because the diagnosis failed.",
        Some(diagnosis) if diagnosis.verdict == Verdict::NotJudged => {
            "Not looked for, because the runs are not plausible or not whole."
        }
        _ => NO_PLACE,
    }
}

/// A wave that stands out of what remains.
pub fn wave(axis: &str, wave: &SpectrumWave) -> String {
    let after = um(wave.rms_um_after);
    format!(
        "{axis}: a wave of {} rms. {} With it in the model {after} rms remain.",
        um(wave.rms_um),
        wave.words
    )
}

/// An axis that was read at too few positions to say that nothing waves along it, and the most that does; `None` of one that is judged.
pub fn not_judged(spectrum: &AxisSpectrum) -> Option<String> {
    let [value, rms_um] = spectrum.highest().filter(|_| !spectrum.judged)?;
    let repeats = match spectrum.unit.as_str() {
        "mm" => format!("every {} mm", plain(value)),
        _ => format!("{} times per turn", plain(value)),
    };
    Some(format!(
        "{}: too few positions to say whether a wave stands out. The largest has {} rms of {} in all, {repeats}.",
        spectrum.axis,
        um(rms_um),
        um(spectrum.rms_um),
    ))
}

/// What an all-clear is worth.
pub fn noticeable(diagnosis: &Diagnosis) -> Option<String> {
    let noticeable_um = diagnosis.noticeable_um.filter(|_| diagnosis.verdict == Verdict::NoiseFloor)?;
    let noticed = format!("A usual effect of {} rms or more would have been noticed.", um(noticeable_um));
    // What passes differ by is part of the noise, and looks like either.
    let passes_um = diagnosis.noise.passes_um;
    Some(match passes_um > noticeable_um {
        true => format!(
            "{noticed} Not so backlash or a slip of the setup: passes differ by some {}, and these data do not say why. Repeat one \
             pass to know.",
            um(passes_um)
        ),
        false => noticed,
    })
}

/// What of the residual comes back although nothing is missing that has a name: no noise, and smaller than the repeatability.
pub fn remaining_pattern(diagnosis: &Diagnosis) -> Option<String> {
    let pattern_um = diagnosis.noise.pattern_um;
    let is_said = diagnosis.verdict == Verdict::NoiseFloor
        && diagnosis.noticeable_um.is_some_and(|noticeable_um| pattern_um > noticeable_um);
    is_said.then(|| {
        format!(
            "A pattern over the positions of some {} comes back, smaller than the repeatability; no effect or expression describes it.",
            um(pattern_um)
        )
    })
}

fn named(diagnosis: &Diagnosis, best: &Candidate) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(about) = about(&best.effect) {
        sentences.push(about.explanation.into());
        sentences.push(format!("Likely cause: {}", about.cause));
    }
    sentences.push(format!(
        "With this effect in the model the residual {} rms ({}).",
        goes(diagnosis.residual.rms_um, best.rms_um_after),
        repeatability(diagnosis.residual.noise_um, diagnosis.residual.noise_readings)
    ));
    sentences.push(match (remains(best), best.confused_with.is_empty()) {
        (None, true) => {
            "Nothing structured remains after it, and nothing else explains these data as well.".into()
        }
        (None, false) => {
            "Nothing structured remains after it, but other causes are confounded with it in these data."
                .into()
        }
        (Some(remains), _) => remains.into(),
    });
    sentences
}

/// Names of effects, as lists in other languages take them.
pub(crate) fn names(found: &[&Candidate]) -> String {
    found.iter().map(|one| effect_name(&one.effect)).collect::<Vec<_>>().join("; ")
}

/// Whether a candidate leads, or was found together with the one that does.
pub(crate) fn is_found(diagnosis: &Diagnosis, candidate: &Candidate) -> bool {
    match diagnosis.found_together() {
        Some((found, _)) => found.iter().any(|one| one.effect == candidate.effect),
        None => diagnosis.best().as_ref() == Some(&candidate.effect),
    }
}

/// How large a candidate is: as fitted with what was found together with it, else alone.
pub(crate) fn sizes<'d>(diagnosis: &'d Diagnosis, candidate: &'d Candidate) -> Vec<&'d Parameter> {
    fitted(diagnosis, candidate).into_iter().filter(|p| p.observable).collect()
}

/// Which of its parameters have no size.
pub(crate) fn without_size(diagnosis: &Diagnosis, candidate: &Candidate) -> Option<String> {
    let of_sight: Vec<_> =
        fitted(diagnosis, candidate).into_iter().filter(|p| !p.observable).map(|p| p.name.as_str()).collect();
    (!of_sight.is_empty()).then(|| format!("Not observable in these runs: {}.", of_sight.join(", ")))
}

fn fitted<'d>(diagnosis: &'d Diagnosis, candidate: &'d Candidate) -> Vec<&'d Parameter> {
    match diagnosis.found_together() {
        Some((_, together)) if is_found(diagnosis, candidate) => together.parameters_of(&candidate.effect),
        _ => candidate.parameters.iter().collect(),
    }
}

/// Where the sizes of a candidate come from, when it is not the fit with it alone, as the figures next to them.
pub(crate) fn sizes_from(diagnosis: &Diagnosis, candidate: &Candidate) -> Option<&'static str> {
    (diagnosis.found_together().is_some() && is_found(diagnosis, candidate))
        .then_some("as fitted with all that was found together")
}

/// Error with a candidate, held-out error, share explained, and whether nothing structured remains.
pub(crate) fn candidate_figures(one: &Candidate) -> [String; 4] {
    figures(one.rms_um_after, one.holdout_rms_um_after, one.explains_fraction, one.adequate)
}

/// The same of everything that was found together.
pub(crate) fn together_figures(all: &Together) -> [String; 4] {
    figures(all.rms_um_after, all.holdout_rms_um_after, all.explains_fraction, all.adequate)
}

fn figures(rms_um: f64, holdout_rms_um: Option<f64>, explains: f64, adequate: bool) -> [String; 4] {
    let remains = if adequate { "yes" } else { "no" }.into();
    [um(rms_um), um_or_dash(holdout_rms_um), percent(explains), remains]
}

fn several(diagnosis: &Diagnosis, found: &[&Candidate], together: &Together) -> Vec<String> {
    let mut sentences = Vec::new();
    for one in found {
        if let Some(about) = about(&one.effect) {
            sentences.push(format!("{}: {}", effect_name(&one.effect), about.explanation));
            sentences.push(format!("Likely cause: {}", about.cause));
        }
    }
    sentences.push(format!(
        "With these {} effects in the model the residual {} rms ({}).",
        found.len(),
        goes(diagnosis.residual.rms_um, together.rms_um_after),
        repeatability(diagnosis.residual.noise_um, diagnosis.residual.noise_readings)
    ));
    let is_confounded = found.iter().any(|one| !one.confused_with.is_empty());
    sentences.push(match (together.adequate, is_confounded) {
        (true, false) => {
            "Nothing structured remains after them, and nothing else explains these data as well.".into()
        }
        (true, true) => "Nothing structured remains after them, but other causes are confounded with some of them in these data."
            .into(),
        (false, _) if together.explains_all => {
            "Nothing structured remains after them, but an error along an axis that goes one way would read the same as one of them."
                .into()
        }
        (false, _) => "They do not explain everything: a part remains.".to_string(),
    });
    sentences
}

fn unnamed(diagnosis: &Diagnosis, formula: &FormulaProposal) -> String {
    let part = match diagnosis.residual.noise_um {
        Some(noise_um) if formula.rms_um_after > 1.25 * noise_um => "so a part remains even then",
        Some(_) => "which is down to the repeatability",
        None => "and how much of that is noise is not known",
    };
    let resembles = formula.resembles.as_ref().map_or(String::new(), |id| {
        format!(" The named effect closest to it is {}, which does not fit fully.", effect_name(id))
    });
    format!(
        "It looks like a {}. An expression for it leaves {} rms, {part}.{resembles}",
        formula.location,
        um(formula.rms_um_after)
    )
}

/// What the bars and marks of a chart of errors are; `units`: what was left out of the fits in turn; `noise_um`: where a line is drawn.
pub fn bars_legend(units: &[&str], noise_um: Option<f64>) -> String {
    let held_out = match units.is_empty() {
        true => String::new(),
        false => format!(" Diamonds: error on {} left out of the fit.", units.join(" or ")),
    };
    let dashed = noise_um.filter(|n| n.is_finite()).map_or("", |_| " Dashed: repeatability.");
    format!("Bars: error of the fit.{held_out}{dashed}")
}

/// What was left out of the fits in turn, as [`bars_legend`] takes it.
pub fn units(unit: Option<LeftOut>) -> Vec<&'static str> {
    unit.map(LeftOut::plural).into_iter().collect()
}

/// What was left out of the fits of a ladder in turn, each once.
pub fn units_of(ladder: &Ladder) -> Vec<&'static str> {
    let mut units: Vec<&str> = Vec::new();
    for (_, row) in ladder.added() {
        let unit = row.holdout_unit.as_deref().and_then(LeftOut::named).map(LeftOut::plural);
        units.extend(unit.filter(|unit| !units.contains(unit)));
    }
    units
}

/// What the shares of candidates are shares of.
pub const EXPLAINS: &str = "Explains: the share of what all that was found explains together.";

/// The row of what was found together in a table of candidates.
pub const TOGETHER: &str = "all found together";

/// Said where no place can be blamed: nothing is left, or it is spread over everything.
pub const NO_PLACE: &str = "No place stands out from the others.";
