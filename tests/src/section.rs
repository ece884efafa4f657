//! Sections of a document that a command writes: what is between two marks. Tests of other crates that write a section take this file
//! in by its path.

use std::path::{Path, PathBuf};

/// A document cut at the marks of one section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// Up to and with the first mark.
    pub before: &'a str,
    /// What the command writes.
    pub inside: &'a str,
    /// From the second mark on.
    pub after: &'a str,
}

impl<'a> Section<'a> {
    /// The two marks of a section of that name.
    pub fn marks(name: &str) -> (String, String) {
        (format!("<!-- begin: {name} -->\n"), format!("<!-- end: {name} -->\n"))
    }

    /// The section of that name; `None` when a mark is missing.
    pub fn of(document: &'a str, name: &str) -> Option<Self> {
        let (begin, end) = Self::marks(name);
        let from = document.find(&begin)? + begin.len();
        let to = from + document[from..].find(&end)?;
        Some(Self { before: &document[..from], inside: &document[from..to], after: &document[to..] })
    }

    /// The document with something else in the section.
    pub fn with(&self, inside: &str) -> String {
        [self.before, inside, self.after].concat()
    }
}

/// Writes the section of a document of the workspace when TRUNNION_WRITE_DOCS is set, else compares it.
///
/// # Panics
/// When the document has no such section, or when it is old.
pub fn write_or_compare(document: &str, name: &str, inside: &str) {
    let path = workspace_root().join(document);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{document}: {error}"));
    let section = Section::of(&text, name).unwrap_or_else(|| panic!("{document} has no section {name}"));
    if is_writing() {
        std::fs::write(&path, section.with(inside)).unwrap_or_else(|error| panic!("{document}: {error}"));
    } else {
        assert_eq!(section.inside, inside, "{document} is old: run this test with TRUNNION_WRITE_DOCS=1");
    }
}

/// Root folder of the workspace, from any of its crates.
pub fn workspace_root() -> PathBuf {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.find(|folder| folder.join("Cargo.lock").is_file()).expect("a crate of the workspace").to_owned()
}

/// True when tests that measure write what they measured into the documents.
pub fn is_writing() -> bool {
    std::env::var_os("TRUNNION_WRITE_DOCS").is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_is_replaced_and_the_rest_stays() {
        let (begin, end) = Section::marks("table");
        let document = format!("head\n{begin}old\n{end}tail\n");
        let section = Section::of(&document, "table").unwrap();
        assert_eq!(section.inside, "old\n");
        assert_eq!(section.with("new\n"), format!("head\n{begin}new\n{end}tail\n"));
        assert_eq!(Section::of(&document, "other"), None);
        assert_eq!(Section::of(&end, "table"), None);
    }
}
