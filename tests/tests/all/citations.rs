//! What code and documents cite is in the repository: documents and their sections, links, and sources.
//!
//! A citation of a document is `docs/…` with its sections, for example "docs/design/physics.md" and "§2.1, §9". A source is cited by its
//! key, for example "S1" or "ISO 230-4"; keys are defined in docs/design/references.md.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const REFERENCES: &str = "docs/design/references.md";
/// This file holds wrong citations on purpose.
const SELF: &str = "citations.rs";
/// Endings of files whose citations are checked.
const CITED_FROM: [&str; 3] = ["rs", "md", "toml"];
/// The commands of an adapter are called like sources.
const NOT_SOURCES: &str = "slcan";
/// Documents that nobody has.
const OUTSIDE: [&str; 7] = ["METHODS", "DESIGN", "NUMERICS", "HARDWARE", "DIAGNOSIS", "GLOSSARY", "STYLE"];
const PUBLISHERS: [&str; 10] =
    ["ISO/TR", "ISO/TS", "ISO/CD", "ISO/FDIS", "ISO", "CiA", "JCGM", "OPC", "NAS", "VDI"];
/// Sources without a number.
const BY_NAME: [&str; 3] = ["GUM", "VIM", "NIST"];

#[test]
fn every_citation_resolves() {
    let files = files(Path::new(ROOT));
    let library = Library::new(&files);
    let mut found = Found::default();
    for (path, text) in &files {
        library.check(path, text, &mut found);
    }
    assert!(found.problems.is_empty(), "{}", found.problems.join("\n"));
    // A walk that finds nothing proves nothing.
    assert!(found.documents > 100 && found.sections > 100 && found.files > 100, "{found:?}");
    assert!(found.links > 50 && found.sources > 100, "{found:?}");
}

#[test]
fn a_citation_that_leads_nowhere_is_found() {
    let document = "# Title\n\n## 1. Notation\n\n### 1.2 Two words, `code`\n\n```\n# no heading\n```\n";
    let keys = "- **S1**, **Oyama 2010**: a paper.\n- **ISO 230-4**: a standard.\n";
    let texts = [("docs/a.md", document), (REFERENCES, keys), ("docs/use/b.md", "")];
    let files: Vec<_> = texts.iter().map(|(path, text)| (PathBuf::from(path), (*text).to_string())).collect();
    let library = Library::new(&files);
    let problems = |path: &str, text: &str| {
        let mut found = Found::default();
        library.check(Path::new(path), text, &mut found);
        found.problems.len()
    };
    for right in [
        "// docs/a.md §1, §1.2 and docs/use/b.md.",
        "// docs/a.md §1–1.2 [S1 §7; ISO 230-4:2005 clause 3] (Oyama et al. 2010), docs/use",
        "const STYLE: &str = \"{STYLE}\";",
        "// `S7`",
    ] {
        assert_eq!(problems("crates/c/src/lib.rs", right), 0, "{right}");
    }
    for wrong in [
        "// docs/c.md",
        "// docs/a.md §3",
        "// docs/a.md §1, §3",
        "// docs/a.md §1–3",
        "// docs/a.md §1.2.1",
        "// [S7 §1]",
        "// ISO 230-7",
        "// Pearson 1901",
        "// GUM H.3",
        "// METHODS §2",
        "// crates/c/src/moved.rs",
        "let a = 1; // as tests/peers/moved.rs does",
    ] {
        assert_eq!(problems("crates/c/src/lib.rs", wrong), 1, "{wrong}");
    }
    for right in [
        "[a](../a.md#12-two-words-code)",
        "[b](b.md)",
        "`[a](c.md)`",
        "```\n[a](c.md)\n```",
        "[h](https://h)",
    ] {
        assert_eq!(problems("docs/use/b.md", right), 0, "{right}");
    }
    for wrong in ["[a](a.md)", "[a](../a.md#no-heading)", "![a](b.svg)", "[a](#one)"] {
        assert_eq!(problems("docs/use/b.md", wrong), 1, "{wrong}");
    }
}

/// What a check has met.
#[derive(Debug, Default)]
struct Found {
    documents: usize,
    files: usize,
    sections: usize,
    links: usize,
    sources: usize,
    problems: Vec<String>,
}

/// What can be cited.
struct Library {
    headings: BTreeMap<PathBuf, Headings>,
    keys: BTreeSet<String>,
    /// Documents given, and the folders they are in.
    paths: BTreeSet<PathBuf>,
}

#[derive(Default)]
struct Headings {
    /// `2.1` of "### 2.1 Chain".
    numbers: BTreeSet<String>,
    /// `21-chain`.
    anchors: BTreeSet<String>,
}

impl Library {
    fn new(files: &[(PathBuf, String)]) -> Self {
        let markdown = files.iter().filter(|(path, _)| is_markdown(path));
        let headings = markdown.map(|(path, text)| (path.clone(), Headings::of(text))).collect();
        let references = files.iter().find(|(path, _)| path == Path::new(REFERENCES));
        let keys = references.map(|(_, text)| keys(text)).unwrap_or_default();
        let ancestors = files.iter().flat_map(|(path, _)| path.ancestors().map(Path::to_path_buf));
        Self { headings, keys, paths: ancestors.collect() }
    }

    fn has(&self, path: &Path) -> bool {
        self.paths.contains(path) || Path::new(ROOT).join(path).exists()
    }

    fn check(&self, path: &Path, text: &str, found: &mut Found) {
        let is_cited_from = |ending: &str| CITED_FROM.contains(&ending);
        let ending = path.extension().and_then(|ending| ending.to_str());
        if path.ends_with(SELF) || !ending.is_some_and(is_cited_from) {
            return;
        }
        let mut fenced = false;
        for (i, line) in text.lines().enumerate() {
            let before = found.problems.len();
            self.documents(line, found);
            if let Some(prose) = prose(path, line) {
                self.source_files(path, prose, found);
            }
            if path != Path::new(REFERENCES) && !path.components().any(|part| part.as_os_str() == NOT_SOURCES)
            {
                self.sources(line, found);
            }
            outside(line, found);
            if line.trim_start().starts_with("```") {
                fenced = !fenced;
            } else if is_markdown(path) && !fenced {
                self.links(path, line, found);
            }
            for problem in &mut found.problems[before..] {
                *problem = format!("{}:{}: {problem}", path.display(), i + 1);
            }
        }
    }

    /// `docs/…` with sections.
    fn documents(&self, line: &str, found: &mut Found) {
        for (at, _) in line.match_indices("docs/") {
            let before = line[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || "/.-_".contains(c)) {
                continue;
            }
            let of_path = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
            let length = line[at..].find(|c| !of_path(c)).unwrap_or(line.len() - at);
            let (cited, mut rest) = line[at..].split_at(length);
            // A pattern of names.
            if rest.starts_with(['{', '*', '…', '<']) {
                continue;
            }
            found.documents += 1;
            let cited = Path::new(cited.trim_end_matches(['.', '/']));
            if !self.has(cited) {
                found.problems.push(format!("{} does not exist", cited.display()));
                continue;
            }
            let mut separators: &[&str] = &[" §", "` §"];
            while let Some((number, after)) =
                separators.iter().find_map(|s| rest.strip_prefix(s)).and_then(leading_number)
            {
                (rest, separators) = (after, &[", §", " and §", "–", "–§"]);
                found.sections += 1;
                let headings = self.headings.get(cited);
                if !headings.is_some_and(|headings| headings.numbers.contains(number)) {
                    found.problems.push(format!("{} has no section {number}", cited.display()));
                }
            }
        }
    }

    /// `crates/…`, `tests/…` and other files and folders, from the root or, in a crate, from the crate.
    fn source_files(&self, path: &Path, prose: &str, found: &mut Found) {
        let of_path = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
        let of_crate: PathBuf = path.iter().take(2).collect();
        for folder in ["crates/", "hil-sim/", "tests/", "config/", "systemd/", ".ci/"] {
            for (at, _) in prose.match_indices(folder) {
                if prose[..at].chars().next_back().is_some_and(of_path) {
                    continue;
                }
                let length = prose[at..].find(|c| !of_path(c)).unwrap_or(prose.len() - at);
                let (cited, rest) = prose[at..].split_at(length);
                if rest.starts_with(['{', '*', '…', '<']) {
                    continue;
                }
                found.files += 1;
                let cited = Path::new(cited.trim_end_matches(['.', '/', '-']));
                let in_crate = path.starts_with("crates") && self.has(&of_crate.join(cited));
                if !in_crate && !self.has(cited) {
                    found.problems.push(format!("{} does not exist", cited.display()));
                }
            }
        }
    }

    /// Keys of sources: `S1`, `ISO 230-4`, `Pearson 1901`.
    fn sources(&self, line: &str, found: &mut Found) {
        let mut cite = |key: &str| {
            found.sources += 1;
            if !self.keys.contains(key) {
                found.problems.push(format!("{key} is not in {REFERENCES}"));
            }
        };
        let words: Vec<&str> = line.split_whitespace().collect();
        for (i, word) in words.iter().enumerate() {
            let bare = word.trim_matches(|c: char| !c.is_alphanumeric());
            let is_key = matches!(bare.as_bytes(), [b'S', digit] if digit.is_ascii_digit());
            if (is_key && !word.contains('`')) || BY_NAME.contains(&bare) {
                cite(bare);
            }
            let Some(next) = words.get(i + 1) else { continue };
            if PUBLISHERS.contains(&bare) && word.ends_with(bare) {
                let end = next.find(|c: char| !c.is_ascii_digit() && c != '-').unwrap_or(next.len());
                let number = next[..end].trim_end_matches('-');
                if !number.is_empty() {
                    cite(&format!("{bare} {number}"));
                }
            }
            let (author, year) = match (*next, words.get(i + 2), words.get(i + 3)) {
                ("et", Some(&("al." | "al.,")), Some(year)) => (bare, *year),
                (year, ..) => (bare, year),
            };
            if is_name(author)
                && !word.ends_with(['.', ',', ':', ';', ')'])
                && let Some(year) = year_of(year)
            {
                cite(&format!("{author} {year}"));
            }
        }
    }

    /// `[text](path#anchor)`.
    fn links(&self, path: &Path, line: &str, found: &mut Found) {
        let plain: String = line.split('`').step_by(2).collect::<Vec<_>>().join("code");
        for (at, _) in plain.match_indices("](") {
            let target = plain[at + 2..].split(')').next().unwrap_or_default();
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            found.links += 1;
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let linked = if file.is_empty() { path.to_path_buf() } else { next_to(path, file) };
            if !self.has(&linked) {
                found.problems.push(format!("{target}: {} does not exist", linked.display()));
            } else if !anchor.is_empty()
                && !self.headings.get(&linked).is_some_and(|headings| headings.anchors.contains(anchor))
            {
                found.problems.push(format!("{} has no heading #{anchor}", linked.display()));
            }
        }
    }
}

impl Headings {
    fn of(text: &str) -> Self {
        let mut headings = Self::default();
        let mut fenced = false;
        for line in text.lines() {
            fenced ^= line.trim_start().starts_with("```");
            let title = line.trim_start_matches('#');
            if fenced || title.len() == line.len() || !title.starts_with(' ') {
                continue;
            }
            if let Some((number, _)) = leading_number(title.trim()) {
                headings.numbers.insert(number.to_string());
            }
            headings.anchors.insert(anchor(title.trim()));
        }
        headings
    }
}

/// Documents that are not in the repository.
fn outside(line: &str, found: &mut Found) {
    for name in OUTSIDE {
        for (at, _) in line.match_indices(name) {
            let (before, after) = (&line[..at], &line[at + name.len()..]);
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let identifier = before.ends_with("const ") || before.ends_with('{');
            if !identifier && !before.ends_with(is_word) && !after.starts_with(is_word) {
                found.problems.push(format!("{name} is no document of the repository"));
            }
        }
    }
}

/// Bold words before the colon of an entry.
fn keys(references: &str) -> BTreeSet<String> {
    let entries = references.lines().filter_map(|line| line.strip_prefix("- **"));
    let heads = entries.filter_map(|entry| Some(entry.split_once("**:")?.0));
    heads.flat_map(|head| head.split("**, **")).map(str::to_string).collect()
}

/// `2.1` and the rest.
fn leading_number(text: &str) -> Option<(&str, &str)> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let number = text[..end].trim_end_matches('.');
    (!number.is_empty()).then(|| (number, &text[number.len()..]))
}

/// The anchor that a heading gets.
fn anchor(title: &str) -> String {
    let letters = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    letters.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// `file` as the document at `path` names it.
fn next_to(path: &Path, file: &str) -> PathBuf {
    let mut parts: Vec<&str> =
        path.parent().unwrap_or(path).iter().filter_map(|part| part.to_str()).collect();
    for part in file.split('/').filter(|part| *part != ".") {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.iter().collect()
}

fn is_name(word: &str) -> bool {
    let mut letters = word.chars();
    letters.next().is_some_and(char::is_uppercase) && word.len() > 2 && letters.all(char::is_lowercase)
}

/// `1989` of "(1989)," and the like.
fn year_of(word: &str) -> Option<&str> {
    let bare = word.trim_start_matches('(');
    let end = bare.find(|c: char| !c.is_ascii_digit()).unwrap_or(bare.len());
    let (year, rest) = bare.split_at(end);
    let closes = rest.is_empty() || rest.starts_with([')', ']', ',', ';', ':', '.', '"']);
    (year.len() == 4 && (year.starts_with("19") || year.starts_with("20")) && closes).then_some(year)
}

/// What of a line is written for people: a comment, or all of a document.
fn prose<'a>(path: &Path, line: &'a str) -> Option<&'a str> {
    let after = |mark: &str| line.find(mark).map(|at| &line[at + mark.len()..]);
    match path.extension()?.to_str()? {
        "rs" => after("//"),
        "toml" => after("#"),
        "md" => Some(line),
        _ => None,
    }
}

fn is_markdown(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "md")
}

/// Every file of text below `root` that people read or that holds what they read, and was written here; its path relative to it.
pub fn files(root: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() {
                if !name.starts_with('.') && name != "target" {
                    folders.push(path);
                }
            } else if matches!(
                path.extension().and_then(|e| e.to_str()),
                Some("rs" | "md" | "toml" | "js" | "json" | "py" | "pyi" | "rules" | "service" | "conf")
            ) && !name.ends_with(".min.js")
            {
                let relative = path.strip_prefix(root).unwrap().to_path_buf();
                files.push((relative, std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    files.sort();
    files
}
