//! How a command ended.

/// How a command that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything asked for was done.
    Done,
    /// Done, but the data have holes, which have been named.
    DataLoss,
    /// Done, but no verdict was given: the runs are not plausible or not whole.
    Withheld,
}
