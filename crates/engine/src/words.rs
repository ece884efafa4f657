//! Words that several answers share.

use std::error::Error;

/// An error with its causes, for a sentence.
pub(crate) fn chain(error: &dyn Error) -> String {
    let cause = error.source().map_or(String::new(), |cause| format!(": {}", chain(cause)));
    format!("{error}{cause}")
}
