//! An analysis in short, for the list of the recordings.

use trunnion::Compared;
use trunnion::results::{Diagnosis, Identification, Parameter, RunFound, sentences::is_location};

/// An analysis in short.
pub fn found(compared: &Compared) -> RunFound {
    let diagnosed = compared.diagnosed();
    let temperature_degc = diagnosed.fit().experiment().temperature_degc();
    RunFound { temperature_degc, ..in_short(&diagnosed.fit().results(), &diagnosed.results()) }
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
        temperature_degc: None,
    }
}
