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
        named: diagnosis.named(),
        rms_um: fit.rms_um,
        effects: fit.effects.clone(),
        location_errors: fit.parameters.iter().filter(location).cloned().collect(),
        temperature_degc: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::results::{Candidate, Together, Verdict};

    #[test]
    fn what_was_found_together_is_all_there() {
        let ids = ["thermal-expansion", "thermal-drift"].map(String::from);
        let diagnosis = Diagnosis {
            verdict: Verdict::MissingEffect,
            candidates: ids.clone().map(|effect| Candidate { effect, ..Candidate::default() }).into(),
            set: ids.to_vec(),
            together: Some(Together::default()),
            ..Diagnosis::default()
        };
        let found = in_short(&Identification::default(), &diagnosis);
        assert_eq!(found.named, ids);
        assert_eq!(found.candidate.as_ref(), ids.first(), "the first alone is still an id");
    }
}
