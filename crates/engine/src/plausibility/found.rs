//! What a rule found.

/// Something in the runs that no machine can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Implausible {
    /// What is wrong, where, and how large.
    pub finding: String,
    /// The mistake that would explain it, and what to do; empty where none of those tried does.
    pub hypothesis: String,
    /// Root mean square of what is left with the mistake undone, µm; `None` where it is no question of size.
    pub rms_um_with_it: Option<f64>,
}

/// A finding that is no question of size.
pub(super) fn plain(finding: String, hypothesis: &str) -> Implausible {
    Implausible { finding, hypothesis: hypothesis.into(), rms_um_with_it: None }
}
