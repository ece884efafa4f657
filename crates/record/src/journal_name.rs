//! How journals are told from finished files.

use std::path::Path;

/// Ending of a journal, after the name of the finished file.
pub const JOURNAL_ENDING: &str = ".active";

/// True for the name of a journal.
pub fn is_journal(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == &JOURNAL_ENDING[1..])
}
