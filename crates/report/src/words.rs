//! What the numbers say, in sentences: shared by page and terminal.

use crate::CompareInput;
use crate::number::{percent, um, um_or_dash};
use trunnion_diagnose::{Candidate, Diagnosis, Verdict};
use trunnion_effects::About;
use trunnion_effects::catalogue::REGISTRY;

/// What the catalogue knows of an effect id; `None` for a formula or a foreign id.
pub fn about(id: &str) -> Option<&'static About> {
    let phenomenon = id.split(':').next()?;
    REGISTRY.iter().find(|effect| effect.phenomenon == phenomenon).map(|effect| &effect.about)
}

/// `Title (id)`, or the id alone.
pub fn effect_name(id: &str) -> String {
    about(id).map_or(id.into(), |about| format!("{} ({id})", about.title))
}

/// What is wrong, how big, and which effect is missing where that is known.
pub fn headline(input: &CompareInput) -> String {
    let rms_um = input.identification.rms_um;
    let left = um(rms_um);
    match &input.diagnosis {
        Some(diagnosis) => verdict_sentence(diagnosis, rms_um),
        None => match input.identification.noise.rms_um {
            Some(noise_um) if rms_um > 1.25 * noise_um => format!(
                "The model leaves an error of {left} rms, {:.1} times the noise floor of {}: something is missing from it.",
                rms_um / noise_um,
                um(noise_um)
            ),
            Some(noise_um) => {
                format!(
                    "The model describes the machine down to the noise: {left} rms left, noise floor {}.",
                    um(noise_um)
                )
            }
            None => format!("The model leaves an error of {left} rms; how much of it is noise is not known."),
        },
    }
}

/// The verdict of a diagnosis as one sentence; `rms_um` is the error that the model leaves.
pub fn verdict_sentence(diagnosis: &Diagnosis, rms_um: f64) -> String {
    let left = um(rms_um);
    let noise = um(diagnosis.residual.noise_um);
    match (diagnosis.verdict, diagnosis.candidates.first(), &diagnosis.formula) {
        (Verdict::NoiseFloor, ..) => {
            format!(
                "Nothing is missing that these data can show: {left} rms is left, the noise floor is {noise}."
            )
        }
        (Verdict::MissingEffect, Some(best), _) => format!(
            "The model misses {}: with it the error falls from {left} to {} rms (noise floor {noise}).{}",
            effect_name(&best.effect),
            um(best.rms_um_after),
            if best.adequate { "" } else { " A part remains unexplained." }
        ),
        (_, _, Some(formula)) => format!(
            "Something without a name in the catalogue is missing from the model: {}, {left} rms left against a noise floor of {noise}.",
            formula.lives
        ),
        _ => format!(
            "Something without a name in the catalogue is missing from the model: {left} rms left against a noise floor of {noise}."
        ),
    }
}

/// The numbers of a candidate in one line.
pub fn candidate_figures(candidate: &Candidate) -> String {
    format!(
        "error after {}, held-out {}, explains {} of what is above the noise, evidence 10^{:.1} : 1",
        um(candidate.rms_um_after),
        um_or_dash(Some(candidate.holdout_rms_um_after)),
        percent(candidate.explains_fraction),
        candidate.evidence
    )
}

/// Which cause and which measurement go with an effect: label and text, for those the catalogue knows.
pub fn explanation(id: &str) -> Vec<(&'static str, &'static str)> {
    about(id).map_or(Vec::new(), |about| {
        vec![
            ("What it is", about.explanation),
            ("Likely cause", about.cause),
            ("Seen by", about.seen_by),
            ("Source", about.source),
        ]
    })
}
