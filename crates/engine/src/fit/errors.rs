//! How far a model is from the readings that it was fitted to, and from those left out.

/// Errors of a fit.
#[derive(Clone, Copy)]
pub(crate) struct Errors {
    pub rms_mm: f64,
    /// `None` where nothing can be left out.
    pub holdout_rms_mm: Option<f64>,
}

impl Errors {
    /// Smaller in the fit, and on what is left out of it where anything can be.
    pub fn are_below(&self, others: &Self) -> bool {
        let held_out = self.holdout_rms_mm.zip(others.holdout_rms_mm);
        self.rms_mm < others.rms_mm && held_out.is_none_or(|(own, of_others)| own < of_others)
    }
}
