//! What the numbers say, in sentences: shared by page, terminal and every other surface. Each thing is said once.

mod size;
mod symbols;

pub use size::{at_tool_um, is_clear};
pub use symbols::{
    as_axes_stand, error_in_words, is_location, location_sentence, setting_in_words, unnumbered_locations,
};

use crate::number::{degrees, justified, plain, um, unit_on_screen};
use crate::{
    Approach, Candidate, Complete, Diagnosis, Doubt, FormulaProposal, Identification, LeftOut, Missing,
    Moved, PlannedCycle, Plausibility, Residual, Samples, ShapeNumber, Verdict,
};
use std::f64::consts::LN_10;
use trunnion_effects::catalogue::effect;
pub use trunnion_effects::catalogue::effect_name;
pub use trunnion_effects::sources::{sources, with_authors};
use trunnion_effects::{About, Role};
use trunnion_engine::diagnosis::options::CLAIM_LN;

/// What the catalogue knows of an effect id; `None` for a formula or a foreign id.
pub fn about(id: &str) -> Option<&'static About> {
    effect(id).map(|effect| &effect.about)
}

/// True for what mounting and artefact leave unknown: it belongs to a run, not to the machine.
pub fn is_setting(id: &str) -> bool {
    effect(id).is_some_and(|effect| effect.role == Role::Setting)
}

/// What is planned, read, missing and excluded; empty where nothing was planned, nothing excluded and nothing lost.
pub fn complete(complete: &Complete) -> Vec<String> {
    let read =
        complete.planned.map(|planned| format!("{} of {planned} planned points were read.", complete.read));
    let missing = complete.missing.iter().map(|part| {
        let Missing { run, setup, count, planned, points } = part;
        format!("{run}, setup {setup}: {count} of {planned} points are missing ({points}).")
    });
    let excluded = complete.excluded.iter().map(|part| match part.count {
        1 => format!("1 point is excluded: {}.", part.reason),
        count => format!("{count} points are excluded: {}.", part.reason),
    });
    let lost = complete.losses.iter().map(|loss| format!("Data loss: {loss}"));
    let samples = complete.samples.iter().map(samples);
    read.into_iter().chain(missing).chain(excluded).chain(samples).chain(lost).collect()
}

/// What became of the samples of one run.
pub fn samples(samples: &Samples) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let excluded: Vec<String> = samples
        .excluded
        .iter()
        .map(|part| format!("{} ({}): {}", part.count, percent(part.share), part.reason))
        .collect();
    let excluded =
        if excluded.is_empty() { String::new() } else { format!(" Excluded: {}.", excluded.join("; ")) };
    format!(
        "{}: {} of {} samples on the fly were used ({}); the stamps of the axes jitter by {:.2} ms.{excluded}",
        samples.run,
        samples.used,
        samples.all,
        percent(samples.share_used),
        samples.jitter_ms
    )
}

/// Why nothing was judged: what is not plausible or not whole, the mistakes that would explain it, and what to repeat.
pub fn not_plausible(found: &[Plausibility]) -> String {
    let sentences = found.iter().flat_map(|one| [one.finding.as_str(), one.hypothesis.as_str()]);
    sentences.filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Numbers of a fit to doubt, and what of its readings: what every text and page that shows the fit says.
pub fn doubts(fit: &Identification) -> Vec<String> {
    doubts_of(&fit.doubts)
}

/// Doubts in sentences.
pub fn doubts_of(doubts: &[Doubt]) -> Vec<String> {
    doubts.iter().map(|doubt| format!("Doubt: {}", doubt.words)).collect()
}

/// Where the verdict is an all-clear.
pub const ALL_CLEAR: &str = "No effect is missing from the model that these data can show.";

/// The title of an effect without its id, or the id where it has none.
pub fn effect_title(id: &str) -> &str {
    about(id).map_or(id, |about| about.title)
}

/// A verdict in a list of runs.
pub fn verdict_in_short(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::MissingEffect => "an effect is missing",
        Verdict::UnnamedStructure => "something without a name is missing",
        Verdict::NoiseFloor => "nothing is missing",
        Verdict::Undecided => "undecided",
        Verdict::NotJudged => "not judged",
    }
}

/// The name of a parameter among others, each given as effect and name: with its effect where another effect has the same name.
pub fn name_among<'a>(
    effect: &str,
    name: &str,
    mut others: impl Iterator<Item = (&'a str, &'a str)>,
) -> String {
    match others.any(|(of, other)| other == name && of != effect) {
        true => format!("{name} of {effect}"),
        false => name.into(),
    }
}

/// True when an expression leads the named effects.
pub fn formula_leads(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::UnnamedStructure && diagnosis.formula.is_some()
}

/// `EX0C −3.20 → −1.10 µm, 8 u`.
pub fn moved_words(moved: &Moved) -> String {
    format!(
        "{} {} → {} {}, {:.0} u",
        moved.name,
        justified(moved.before, moved.u),
        justified(moved.after, moved.u),
        unit_on_screen(&moved.unit),
        moved.in_u()
    )
}

/// The location error that moved most.
pub fn most_moved(moved: &[Moved]) -> Option<&Moved> {
    moved.iter().find(|m| is_location(&m.name))
}

/// What the log₁₀ of odds means.
pub fn evidence_words(evidence: f64) -> String {
    let odds = match evidence {
        e if e >= 6.0 => "more than a million to one".into(),
        // One digit: more is not known of odds.
        e if e >= 3.0 => format!("about {:.0} to one", one_digit(10_f64.powf(e))),
        e => format!("{} to one", plain(10_f64.powf(e))),
    };
    let word = match evidence {
        e if e >= 4.0 => "It is significant",
        // What is claimed is not called noise.
        e if e * LN_10 >= CLAIM_LN => "It is probably significant",
        _ => "It may be noise",
    };
    format!(
        "{word}: {odds} against noise only (odds after the prior {})",
        trunnion_core::number::odds(evidence)
    )
}

/// A number rounded to its first digit.
fn one_digit(number: f64) -> f64 {
    let power = 10_f64.powf(number.log10().floor());
    (number / power).round() * power
}

/// `falls from 2.72 µm to 1.49 µm`, as its figures on screen go: `stays at 2.72 µm` where they are one.
pub fn goes(before_um: f64, after_um: f64) -> String {
    let (before, after) = (um(before_um), um(after_um));
    match () {
        () if before == after => format!("stays at {after}"),
        () if after_um < before_um => format!("falls from {before} to {after}"),
        () => format!("rises from {before} to {after}"),
    }
}

/// What a candidate is, its likely cause, and what speaks for it.
pub(crate) fn why(candidate: &Candidate, residual: &Residual) -> String {
    let catalogue =
        about(&candidate.effect).map(|about| format!("{} Likely cause: {}", about.explanation, about.cause));
    catalogue.into_iter().chain([beyond_catalogue(candidate, residual)]).collect::<Vec<_>>().join(" ")
}

/// What a diagnosis says of a candidate beyond what the catalogue says of the effect.
pub fn beyond_catalogue(candidate: &Candidate, residual: &Residual) -> String {
    let held_out = residual.holdout_rms_um.zip(residual.holdout_unit).zip(candidate.holdout_rms_um_after);
    let held_out = held_out.map_or(String::new(), |((before, unit), after)| {
        format!("on {} left out of the fit it {}; ", unit.plural(), goes(before, after))
    });
    let falls = format!(
        "With it alone the error {} ({held_out}{}).",
        goes(residual.rms_um, candidate.rms_um_after),
        repeatability(residual.noise_um, residual.noise_readings)
    );
    let remains = remains(candidate).unwrap_or("Nothing structured remains.");
    let remarks = candidate.remarks.iter().map(String::as_str);
    remarks.chain([falls.as_str(), remains]).collect::<Vec<_>>().join(" ")
}

/// What keeps a candidate from explaining the readings alone; `None` where nothing does.
pub fn remains(candidate: &Candidate) -> Option<&'static str> {
    match (candidate.adequate, candidate.explains_all) {
        (true, _) => None,
        (false, true) => Some(
            "Nothing structured remains, but an error along an axis that goes one way would read the same.",
        ),
        (false, false) => Some("A part remains that it does not explain."),
    }
}

/// Which cause goes with an effect: label and text, for those the catalogue knows.
pub fn explanation(id: &str) -> Vec<(&'static str, String)> {
    about(id).map_or(Vec::new(), |about| {
        let source = sources(about.source);
        let mut said = vec![
            ("What it is", about.explanation.to_string()),
            ("Likely cause", about.cause.into()),
            ("Valid", with_authors(about.validity)),
        ];
        if !source.is_empty() {
            said.push(("Source", source));
        }
        said
    })
}

/// What a planned cycle costs and settles.
pub fn planned_words(cycle: &PlannedCycle) -> String {
    let pair = |[a, b]: &[String; 2]| format!("{} from {}", effect_name(a), effect_name(b));
    let pairs: Vec<String> = cycle.separates.iter().map(pair).collect();
    format!(
        "Cycle \"{}\": about {:.0} minutes of machine time with mounting. {}",
        cycle.name,
        cycle.minutes,
        match pairs.is_empty() {
            true => format!("It is {}; `trunnion diagnose --json` holds its file.", cycle.what),
            false => format!(
                "It separates {}. The command \"trunnion plan\" with the same recordings and model writes its file.",
                pairs.join("; ")
            ),
        }
    )
}

/// Where a formula acts: `dx, dz at axis:B`.
pub fn formula_site(formula: &FormulaProposal) -> String {
    format!("{} at {}", formula.components.join(", "), formula.site)
}

/// The id under which a formula is added.
pub fn formula_id(formula: &FormulaProposal) -> String {
    trunnion_effects::Formula::id_of(&formula.name)
}

/// The shape numbers of a formula: `at = 32.0°, width = 12.4°`; empty when it has none.
pub fn formula_shape(formula: &FormulaProposal) -> String {
    let number = |n: &ShapeNumber| match n.unit.as_str() {
        "rad" => format!("{} = {}", n.name, degrees(n.value)),
        "1" => format!("{} = {:.2}", n.name, n.value),
        unit => format!("{} = {} {unit}", n.name, plain(n.value)),
    };
    formula.shape.iter().map(number).collect::<Vec<_>>().join(", ")
}

/// Where the repeatability of a fit comes from.
pub fn noise_origin(fit: &Identification) -> String {
    let side = match fit.noise_approach {
        Some(Approach::OneSide) => ", those from one side",
        Some(Approach::BothSides) => ", all from both sides",
        Some(Approach::NoMatter) | None => "",
    };
    fit.repeats.map_or_else(
        || "not known: no pose was measured twice".into(),
        |repeats| {
            let means = of_means(fit.noise_readings);
            format!("poses measured more than once, {repeats} repeats{side}{means}")
        },
    )
}

/// How well readings repeat, for a bracket; `readings`: how many are averaged in one.
pub fn repeatability(noise_um: Option<f64>, readings: Option<f64>) -> String {
    noise_um.map_or_else(
        || "repeatability not known: no pose was measured twice".into(),
        |noise_um| format!("repeatability {}{}", um(noise_um), of_means(readings)),
    )
}

/// What a figure is of, where it is not one of single readings.
fn of_means(readings: Option<f64>) -> String {
    let count = readings.map_or_else(String::new, |readings| match readings {
        few if few < 10.0 => format!("{few:.1}").trim_end_matches(".0").into(),
        many => format!("{many:.0}"),
    });
    match count.as_str() {
        "" | "1" => String::new(),
        count => format!(", of means of {count} readings"),
    }
}

/// How far the numbers of an inadequate model hold, and of one of which nothing says whether it is one; `None` where it may hold.
pub fn inadequate(fit: &Identification) -> Option<String> {
    match (fit.model_adequate, fit.noise_um) {
        (Some(false), _) => Some(format!(
            "These numbers hold only as far as the model does: it leaves {} rms ({}).",
            um(fit.rms_um),
            repeatability(fit.noise_um, fit.noise_readings)
        )),
        (None, None) => Some(format!(
            "No pose was measured twice: whether the {} rms that the model leaves are noise is not known, and these numbers hold only if they \
             are.",
            um(fit.rms_um)
        )),
        _ => None,
    }
}

/// What was left out of the fit for its held-out error.
pub fn left_out(unit: Option<LeftOut>) -> String {
    unit.map_or_else(
        || "no part of these data predicts another".into(),
        |unit| format!("on {} left out of the fit", unit.plural()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odds_are_said_to_their_first_digit() {
        let said =
            |evidence| evidence_words(evidence).split(" against").next().unwrap_or_default().to_owned();
        assert_eq!(said(3.3), "It is probably significant: about 2000 to one");
        assert_eq!(said(4.5), "It is significant: about 30000 to one");
        assert_eq!(said(5.999), "It is significant: about 1000000 to one");
        assert_eq!(said(2.0), "It is probably significant: 100 to one");
    }

    #[test]
    fn a_repeatability_of_means_says_of_how_many() {
        let said = |readings: f64| repeatability(Some(0.386), Some(readings));
        assert_eq!(said(1.0), "repeatability 0.39 µm");
        assert_eq!(said(1.46), "repeatability 0.39 µm, of means of 1.5 readings");
        assert_eq!(said(119.7), "repeatability 0.39 µm, of means of 120 readings");
        let fit = Identification {
            repeats: Some(168),
            noise_approach: Some(Approach::BothSides),
            noise_readings: Some(2.0),
            ..Identification::default()
        };
        let origin =
            "poses measured more than once, 168 repeats, all from both sides, of means of 2 readings";
        assert_eq!(noise_origin(&fit), origin);
    }

    #[test]
    fn an_error_that_rises_is_not_said_to_fall() {
        let residual = Residual {
            rms_um: 1.68,
            holdout_rms_um: Some(3.1),
            holdout_unit: Some(LeftOut::Pass),
            ..Residual::default()
        };
        let of = |rms_um_after: f64, holdout: f64| {
            let holdout_rms_um_after = Some(holdout);
            beyond_catalogue(
                &Candidate { rms_um_after, holdout_rms_um_after, ..Candidate::default() },
                &residual,
            )
        };
        let said = of(1.49, 3.72);
        assert!(
            said.contains("falls from 1.68 µm to 1.49 µm")
                && said.contains("it rises from 3.10 µm to 3.72 µm"),
            "{said}"
        );
        assert!(of(1.681, 3.0).contains("With it alone the error stays at 1.68 µm"));
    }
}
