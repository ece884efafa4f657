//! What is fuzzed of one reader. The tables are read by the tests next to it, and by the fuzzer in `tests/fuzz`, which takes them in by
//! their paths.

/// One reader of what comes from outside.
pub struct Entry {
    /// What it reads.
    pub name: &'static str,
    /// The files of the repository in which text or bytes become something.
    pub read_in: &'static [&'static str],
    /// Reads; whatever comes out is dropped.
    pub read: fn(&[u8]),
    /// Good ones: files of the repository, or small ones made here.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

pub fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

/// A hand-written file without its comments and empty lines: all of it is read, so that every change counts.
pub fn without_comments(file: &[u8]) -> Vec<u8> {
    let text = text(file);
    let lines = text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
    lines.flat_map(|line| [line, "\n"]).collect::<String>().into_bytes()
}
