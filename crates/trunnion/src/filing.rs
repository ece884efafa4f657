//! A report to be filed: an analysis with the identity of machine and recordings, and pass or fail.

use crate::{Compared, Error, identity, page};
use std::path::PathBuf;
use trunnion_results::{Identity, Report, Verdict};

/// What a person says of a report; what is missing is taken from the recording, else it is not recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filing {
    /// Serial number of the machine.
    pub serial: Option<String>,
    /// Who measured.
    pub operator: Option<String>,
    /// Tolerance, µm.
    pub tolerance_um: Option<f64>,
    /// Today, `YYYY-MM-DD`.
    pub written: String,
}

impl Compared {
    /// The report on these recordings; `paths` are those that were opened, in order.
    ///
    /// # Errors
    /// A recording that cannot be read again, or settings that cannot be fitted alone.
    pub fn report(&self, paths: &[PathBuf], filing: &Filing) -> Result<Report, Error> {
        let fit = self.diagnosed().fit();
        let mut runs = Vec::new();
        for (path, run) in paths.iter().zip(fit.experiment().runs()) {
            runs.push(identity::of_run(path, run)?);
        }
        let plate = fit.experiment().plate();
        let serial = filing.serial.clone().or_else(|| plate.serial.clone());
        let tolerance = match (filing.tolerance_um, plate.tolerance_um) {
            (Some(asked), _) => Some((asked, "given with the command")),
            (None, Some(of_file)) => Some((of_file, "machine file in the recording")),
            (None, None) => None,
        };
        let comparison = self.results();
        let judged = comparison.diagnosis.as_ref().is_some_and(|d| d.verdict != Verdict::NotJudged);
        let conformity = match tolerance.filter(|_| judged) {
            Some((tolerance_um, of)) => Some(fit.conformity(tolerance_um, of)?),
            None => None,
        };
        let identity = Identity {
            machine: fit.experiment().machine().name.clone(),
            serial,
            operator: filing.operator.clone(),
            program: page::label(),
            written: filing.written.clone(),
            runs,
        };
        Ok(Report { identity, conformity, comparison, ..Report::default() })
    }
}
