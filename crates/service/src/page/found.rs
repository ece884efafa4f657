//! An analysis in short, for the list of the recordings.

use trunnion::results::{Comparison, Diagnosis, Identification, Parameter, RunFound, sentences::is_location};

/// An analysis in short.
pub fn found(compared: &Comparison) -> RunFound {
    let nothing = Diagnosis::default();
    in_short(&compared.identification, compared.diagnosis.as_ref().unwrap_or(&nothing))
}

/// The same of its parts.
pub fn in_short(fit: &Identification, diagnosis: &Diagnosis) -> RunFound {
    let location = |p: &&Parameter| is_location(&p.name) && p.value.is_some();
    RunFound {
        verdict: diagnosis.verdict,
        candidate: diagnosis.best(),
        rms_um: fit.rms_um,
        effects: fit.effects.clone(),
        location_errors: fit.parameters.iter().filter(location).cloned().collect(),
    }
}
