//! Sections of a document that a command writes: what is between two marks.

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
