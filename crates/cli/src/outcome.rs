//! How a command ended.

use trunnion::results::Verdict;

/// How a command that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything asked for was done.
    Done,
    /// Done, but the data have holes, or what was written lacks something; which has been named.
    DataLoss,
    /// Done, but no verdict was given: the runs are not plausible or not whole, or the diagnosis failed.
    Withheld,
}

impl Outcome {
    /// The same with what a diagnosis says.
    pub fn with_verdict(self, verdict: Verdict) -> Self {
        if verdict == Verdict::NotJudged { self.or_withheld() } else { self }
    }

    /// The same where no verdict was given; a loss of data says more.
    pub fn or_withheld(self) -> Self {
        match self {
            Self::Done => Self::Withheld,
            other => other,
        }
    }
}
