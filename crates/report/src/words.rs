//! What the numbers say, in sentences: shared by page and terminal. Each thing is said once.

use crate::number::{degrees, percent, plain, um, um_or_dash, unit_on_screen};
use crate::{CompareInput, ParameterRow, Trial};
use trunnion_effects::catalogue::effect;
use trunnion_effects::{About, Moved, SOURCES};
use trunnion_engine::next_cycle::PlannedCycle;
use trunnion_engine::{Candidate, Diagnosis, FormulaProposal, ShapeNumber, Verdict};

/// A parameter is worth telling when it exceeds this many standard uncertainties.
const CLEAR_U: f64 = 3.0;
/// A turn is weighed against a shift at this distance, mm.
const LEVER_MM: f64 = 100.0;

/// What the catalogue knows of an effect id; `None` for a formula or a foreign id.
pub fn about(id: &str) -> Option<&'static About> {
    effect(id).map(|effect| &effect.about)
}

/// `Title (id)`, or the id alone.
pub fn effect_name(id: &str) -> String {
    about(id).map_or(id.into(), |about| format!("{} ({id})", about.title))
}

/// The answer in one line.
pub fn headline(input: &CompareInput) -> String {
    let rms_um = input.identification.rms_um;
    let left = um(rms_um);
    let Some(diagnosis) = &input.diagnosis else {
        return match input.identification.noise.rms_um {
            Some(noise_um) if rms_um > 1.25 * noise_um => {
                format!(
                    "Something is missing from the model: {left} rms left, repeatability {}",
                    um(noise_um)
                )
            }
            Some(noise_um) => {
                format!("The model reaches the noise: {left} rms left, repeatability {}", um(noise_um))
            }
            None => format!("The model leaves {left} rms; how much of it is noise is not known"),
        };
    };
    match (diagnosis.verdict, diagnosis.candidates.first()) {
        (Verdict::NoiseFloor, _) if input.ladder.is_empty() => {
            "No effect is missing that these data can show".into()
        }
        (Verdict::NoiseFloor, _) => "The model now explains this machine down to the noise".into(),
        (Verdict::MissingEffect, Some(best)) => {
            format!("Missing from the model: {}", effect_name(&best.effect))
        }
        _ => "Something that the catalogue has no name for is missing from the model".into(),
    }
}

/// What is wrong with the machine, for somebody who knows nothing of this program: sentences of one paragraph.
pub fn verdict(input: &CompareInput) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(diagnosis) = &input.diagnosis {
        match (diagnosis.verdict, diagnosis.candidates.first(), &diagnosis.formula) {
            (Verdict::NoiseFloor, ..) => sentences.extend(nothing_left(input, diagnosis)),
            (Verdict::MissingEffect, Some(best), _) => sentences.extend(named(diagnosis, best)),
            (_, _, formula) => {
                sentences.push(format!(
                    "The readings differ from what the model predicts by {} rms ({}): \
                     part of this is no chance, and no effect of the catalogue describes it.",
                    um(diagnosis.residual.rms_um),
                    repeatability(diagnosis.residual.noise_um)
                ));
                if let Some(formula) = formula {
                    sentences.push(unnamed(diagnosis, formula));
                }
            }
        }
    }
    let besides = if sentences.is_empty() { "" } else { "Besides, " };
    sentences.extend(location_sentence(&input.identification.parameters, besides));
    sentences
}

/// How well readings repeat, for a bracket.
pub fn repeatability(noise_um: Option<f64>) -> String {
    noise_um.map_or_else(
        || "repeatability not known: no pose was measured twice".into(),
        |noise_um| format!("repeatability {}", um(noise_um)),
    )
}

fn nothing_left(input: &CompareInput, diagnosis: &Diagnosis) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(first) = input.ladder.first() {
        sentences.push(match input.ladder.len() {
            1 => "One effect was found and put into the model.".into(),
            n => format!("{n} effects were found and put into the model."),
        });
        for row in &input.ladder {
            let explanation = about(&row.effect).map_or("", |about| about.explanation);
            sentences
                .push(format!("{}: {explanation}", effect_name(&row.effect)).trim_end_matches(": ").into());
        }
        sentences.push(format!(
            "With {} the error left falls from {} to {} rms.",
            if input.ladder.len() == 1 { "it" } else { "them" },
            um(first.fit_before_um),
            um(input.identification.rms_um)
        ));
    }
    sentences.push(format!(
        "The model leaves {} rms ({}); nothing in it points at a further cause.",
        um(diagnosis.residual.rms_um),
        repeatability(diagnosis.residual.noise_um)
    ));
    sentences
}

fn named(diagnosis: &Diagnosis, best: &Candidate) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(about) = about(&best.effect) {
        sentences.push(about.explanation.into());
        sentences.push(format!("Likely cause: {}", about.cause));
    }
    sentences.push(format!(
        "With this effect in the model the error left falls from {} to {} rms ({}).",
        um(diagnosis.residual.rms_um),
        um(best.rms_um_after),
        repeatability(diagnosis.residual.noise_um)
    ));
    sentences.push(match (best.adequate, best.confused_with.is_empty()) {
        (true, true) => {
            "Nothing structured remains after it, and nothing else explains these data as well.".into()
        }
        (true, false) => {
            "Nothing structured remains after it, but other causes look alike in these data.".into()
        }
        (false, _) => "It does not explain everything: a part remains.".to_string(),
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
        "It looks like a {}. An expression for it takes {} of it away and leaves {} rms, {part}.{resembles}",
        formula.lives,
        percent(formula.explains_fraction),
        um(formula.rms_um_after)
    )
}

/// True when an expression leads the named effects.
pub fn formula_leads(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::UnnamedStructure && diagnosis.formula.is_some()
}

/// The largest errors of place and direction of the axes, in words.
fn location_sentence(parameters: &[ParameterRow], besides: &str) -> Option<String> {
    let mut errors: Vec<(f64, String)> = parameters
        .iter()
        .filter_map(|p| {
            let (value, u) = p.value.zip(p.u)?;
            let size = if p.unit == "urad" { value.abs() * LEVER_MM * 1e-3 } else { value.abs() };
            (value.abs() > CLEAR_U * u).then_some((size, location_words(&p.name, value)?))
        })
        .collect();
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    errors.truncate(3);
    if errors.is_empty() {
        return None;
    }
    let list = errors.into_iter().map(|(_, words)| words).collect::<Vec<_>>().join("; ");
    let axes = if besides.is_empty() { "Axes" } else { "axes" };
    Some(format!("{besides}{axes} are not where the control believes: {list}."))
}

/// `axis B lies 13.6 µm off along Z` from `EZ0B`; `None` for what is no location error.
fn location_words(name: &str, value: f64) -> Option<String> {
    let (direction, axis) = name.strip_prefix('E')?.split_once('0')?;
    let ([direction], false) = (direction.as_bytes(), axis.is_empty()) else { return None };
    let direction = char::from(*direction);
    match direction {
        'X' | 'Y' | 'Z' => Some(format!("axis {axis} lies {} µm off along {direction}", plain(value))),
        'A' | 'B' | 'C' if axis.strip_prefix(direction) == Some("") => {
            Some(format!("the zero of {axis} is off by {} µrad", plain(value)))
        }
        'A' | 'B' | 'C' => {
            let about = ['X', 'Y', 'Z'][usize::from(direction as u8 - b'A')];
            let over = plain(value * LEVER_MM * 1e-3);
            Some(format!("axis {axis} leans {} µrad about {about} ({over} µm over 100 mm)", plain(value)))
        }
        _ => None,
    }
}

/// True for the parameter names of `location-errors`.
pub fn is_location(name: &str) -> bool {
    location_words(name, 0.0).is_some()
}

/// `EX0C −3.20 → −1.10 µm, 8 u`.
pub fn moved_words(moved: &Moved) -> String {
    format!(
        "{} {} → {} {}, {:.0} u",
        moved.name,
        plain(moved.before),
        plain(moved.after),
        unit_on_screen(&moved.unit),
        moved.in_u()
    )
}

/// The location error that moved most.
pub fn most_moved(moved: &[Moved]) -> Option<&Moved> {
    moved.iter().find(|m| is_location(&m.name))
}

/// What log₁₀ evidence means.
pub fn evidence_words(evidence: f64) -> String {
    let odds = match evidence {
        e if e >= 6.0 => "more than a million to one".into(),
        e if e >= 3.0 => format!("about {} to one", plain(10_f64.powf(e.floor()))),
        e => format!("{} to one", plain(10_f64.powf(e))),
    };
    let word = match evidence {
        e if e >= 4.0 => "It is no chance",
        e if e >= 2.0 => "It is hardly chance",
        e if e >= 1.3 => "It may be chance",
        _ => "It may well be chance",
    };
    format!("{word}: the readings favour it over mere noise {odds} (evidence 10^{evidence:.1})")
}

/// What a diagnosis says of a candidate beyond what the catalogue says of the effect.
pub fn beyond_catalogue(candidate: &Candidate) -> String {
    let mut why = candidate.why.clone();
    if let Some(about) = about(&candidate.effect) {
        for said in [format!("Likely cause: {}", about.cause), about.explanation.into(), about.cause.into()] {
            why = why.replacen(&said, "", 1);
        }
    }
    why.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// How the readings judge a trial, on data that took no part in the fit.
pub fn trial_verdict(trial: &Trial) -> String {
    let [before, after] = trial.fit_um;
    let fit = format!("The error left goes from {} to {} rms", um(before), um(after));
    let then = trial.then.as_ref().map_or(String::new(), |then| format!(" {}", then_sentence(then)));
    let [Some(out_before), Some(out_after)] = trial.holdout_um else {
        return format!(
            "{fit}; there is no pass to leave out, so nothing proves that it predicts anything.{then}"
        );
    };
    let out = format!("on data left out of the fit from {} to {}", um(out_before), um(out_after));
    let word = match out_after / out_before {
        ratio if ratio < 0.9 => "It helps: it also predicts readings it has not seen.",
        ratio if ratio < 0.99 => "It helps a little.",
        ratio if ratio <= 1.01 => "It does not help: what it has not seen it predicts no better.",
        _ => "It harms: what it has not seen it predicts worse.",
    };
    format!("{fit}, {out} (repeatability {}). {word}{then}", um_or_dash(trial.noise.rms_um))
}

/// Said where no place can be blamed: nothing is left, or it is spread over everything.
pub const NO_PLACE: &str = "No place stands out from the others.";

/// What is missing after a trial.
fn then_sentence(then: &Diagnosis) -> String {
    match (then.verdict, then.candidates.first()) {
        (Verdict::NoiseFloor, _) => "Nothing structured remains after it.".into(),
        (Verdict::MissingEffect, Some(next)) => {
            format!("After it the model still misses something, first of all {}.", effect_name(&next.effect))
        }
        _ => "After it something remains that the catalogue has no name for.".into(),
    }
}

/// Which cause goes with an effect: label and text, for those the catalogue knows.
pub fn explanation(id: &str) -> Vec<(&'static str, String)> {
    about(id).map_or(Vec::new(), |about| {
        let source = sources(about.source);
        let mut said = vec![
            ("What it is", about.explanation.to_string()),
            ("Likely cause", about.cause.into()),
            ("Valid", about.validity.into()),
        ];
        if !source.is_empty() {
            said.push(("Source", source));
        }
        said
    })
}

/// The sources of an effect with their authors instead of the catalogue's numbers; empty where it has none of its own.
pub fn sources(source: &str) -> String {
    let public = source.split("; ").filter(|part| !part.starts_with("docs/"));
    let named = |part: &str| {
        let known = SOURCES.iter().find_map(|(number, author)| Some((author, part.strip_prefix(number)?)));
        known.map_or(part.to_string(), |(author, rest)| format!("{author}{rest}"))
    };
    public.map(named).collect::<Vec<_>>().join("; ")
}

/// The same without the figures and the judgement that the page shows elsewhere.
pub fn beyond_figures(candidate: &Candidate) -> String {
    let shown = ["With it the error falls", "Nothing structured remains", "A part remains that"];
    let why = beyond_catalogue(candidate);
    let sentences =
        why.split_inclusive(". ").filter(|s| !shown.iter().any(|start| s.trim_start().starts_with(start)));
    sentences.collect::<String>().trim().to_string()
}

/// What a planned cycle costs and settles.
pub fn planned_words(cycle: &PlannedCycle) -> String {
    let pairs: Vec<String> = cycle.separates.iter().map(|[a, b]| format!("{a} from {b}")).collect();
    format!(
        "Cycle \"{}\": about {:.0} minutes of machine time with mounting. It tells {}. The command \"trunnion plan\" with the \
         same recordings and model writes its file.",
        cycle.name,
        cycle.minutes,
        pairs.join(", ")
    )
}

/// Where a formula acts: `dx, dz at axis:B`.
pub(crate) fn formula_site(formula: &FormulaProposal) -> String {
    let components: Vec<&str> = formula.entries.iter().filter_map(|e| e.component.as_deref()).collect();
    format!("{} at {}", components.join(", "), formula.site)
}

/// The shape numbers of a formula: `at = 32.0°, width = 12.4°`; empty when it has none.
pub(crate) fn formula_shape(formula: &FormulaProposal) -> String {
    let number = |n: &ShapeNumber| match n.unit {
        "rad" => format!("{} = {}", n.name, degrees(n.value)),
        "1" => format!("{} = {:.2}", n.name, n.value),
        unit => format!("{} = {} {unit}", n.name, plain(n.value)),
    };
    formula.shape.iter().map(number).collect::<Vec<_>>().join(", ")
}
