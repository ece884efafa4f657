//! What users read has the words of docs/glossary.md: literals of the crates and of the page's scripts, documents, comments of
//! the configuration, descriptions in schemas, the Python package, the files of systemd.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod javascript;
mod passages;

use crate::citations::{ROOT, files};
use javascript::of_javascript;
use passages::{Passage, names_of_rust, of_markdown, of_rust, of_schema, of_toml};
use std::collections::BTreeSet;
use std::path::Path;

/// What the glossary replaces, and the word to use. A trailing `*` stands for any ending.
const REPLACED: &[(&str, &str)] = &[
    ("tell", "report, show, distinguish"),
    ("tells", "reports, shows, separates"),
    ("telling", "reporting"),
    ("told", "reported"),
    ("anew", "again, reset, restart"),
    ("befall*", "fault"),
    ("befell", "fault"),
    ("mishap*", "outlier, excluded point, fault"),
    ("vigil*", "monitor, stuck detector"),
    ("set aside", "excluded (with the reason)"),
    ("sets aside", "excludes"),
    ("error left", "residual, rms"),
    ("what is left", "residual, remainder"),
    ("is left over", "residual, remainder"),
    ("beside", "next to, in addition to"),
    ("besides", "in addition to, other than"),
    ("duel*", "model comparison"),
    ("contest*", "model comparison"),
    ("contender*", "candidate"),
    ("odds to beat", "Bayes factor"),
    ("no chance", "significant (Bayes factor 10^n against noise only)"),
    ("be chance", "noise, not significant"),
    ("hardly chance", "significant (Bayes factor 10^n against noise only)"),
    ("better than chance", "significant (Bayes factor 10^n against noise only)"),
    ("desk", "design"),
    ("survey*", "design"),
    ("weighs", "ranks by utility"),
    ("phrase*", "expression, term"),
    ("saying*", "candidate, expression"),
    ("kin", "family of terms"),
    ("gesture*", "synchronisation move"),
    ("cannot be seen", "not observable"),
    ("cannot see", "not observable"),
    ("cannot be told", "confounded with, not distinguishable"),
    ("alike", "confounded, the same"),
    ("times as large", "magnification"),
    ("hidden truth*", "ground truth, injected effect"),
    ("was put in", "injected"),
    ("stand free", "dwell, stationary"),
    ("stands free", "dwell, stationary"),
    ("stand still", "dwell, stationary"),
    ("stands still", "dwell, stationary"),
    ("standing still", "dwell, stationary"),
    ("lateness", "latency"),
    ("early by", "skew"),
    ("patience", "timeout"),
    ("spell", "format"),
    ("spells", "formats"),
    ("spelled", "written, serialised"),
    ("spelling*", "format, name"),
    ("in silence", "without a gap, without a message"),
    ("noise floor", "repeatability"),
    ("readings scatter by", "repeatability"),
    ("lives", "is (position, location, path)"),
    ("weighed", "compared, judged, ranked by utility"),
    ("left over", "residual, remainder"),
    ("rms left", "residual {} rms"),
    ("enough alone", "adequate"),
    ("chance of", "probability of, significant"),
];

/// Heads of columns that the glossary replaces.
const REPLACED_HEADS: &[(&str, &str)] = &[("enough", "adequate"), ("kin", "family"), ("put in", "injected")];

/// Words that stay: file or folder, words around them, reason.
const EXCEPTIONS: &[(&str, &str, &str)] = &[];

#[test]
fn users_read_the_words_of_the_glossary() {
    let mut problems = Vec::new();
    let mut used = BTreeSet::new();
    let mut words = 0;
    for (path, text) in &files(Path::new(ROOT)) {
        let path = path.to_str().unwrap();
        for passage in passages(path, text) {
            words += passage.words.len();
            for Hit { line, text, pattern, say } in hits(&passage) {
                let stays = |(place, kept, _): &(&str, &str, &str)| {
                    Path::new(path).starts_with(place) && text.contains(kept)
                };
                match EXCEPTIONS.iter().position(stays) {
                    Some(exception) => _ = used.insert(exception),
                    None => problems.push(format!("{path}:{line}: {text}: \"{pattern}\": say {say}")),
                }
            }
        }
    }
    assert!(problems.is_empty(), "{} against docs/glossary.md:\n{}", problems.len(), problems.join("\n"));
    // A walk that finds nothing proves nothing.
    assert!(words > 10_000, "{words} words");
    let unused: Vec<_> = (0..EXCEPTIONS.len()).filter(|i| !used.contains(i)).map(|i| EXCEPTIONS[i]).collect();
    assert!(unused.is_empty(), "exceptions that nothing needs: {unused:?}");
}

/// Names in the code are searched too; of several words only those of users are asked for, for `noise_floor` is a verdict.
#[test]
fn names_have_the_words_of_the_glossary() {
    let (mut problems, mut count) = (Vec::new(), 0);
    for (path, text) in &files(Path::new(ROOT)) {
        let path = path.to_str().unwrap();
        if path.ends_with(".rs") {
            for name in names_of_rust(text) {
                count += 1;
                let own = hits(&name).into_iter().filter(|hit| !hit.pattern.contains(' '));
                problems
                    .extend(own.map(|hit| format!("{path}:{}: \"{}\": say {}", hit.line, hit.text, hit.say)));
            }
        }
    }
    assert!(problems.is_empty(), "{} against docs/glossary.md:\n{}", problems.len(), problems.join("\n"));
    assert!(count > 100_000, "{count} names");
}

#[test]
fn sentences_are_short() {
    let mut problems = Vec::new();
    for (path, text) in &files(Path::new(ROOT)) {
        let path = path.to_str().unwrap();
        // Documents, and the source of one, have tables, lists and equations in their sentences.
        if path.ends_with(".rs") && path != "crates/effects/src/markdown.rs" {
            for (line, count, text) in passages(path, text).iter().flat_map(Passage::long_sentences) {
                problems.push(format!("{path}:{line}: {count} words: {text}"));
            }
        }
    }
    assert!(problems.is_empty(), "{} sentences to split:\n{}", problems.len(), problems.join("\n"));
}

#[test]
fn a_replaced_word_is_found() {
    let found = |path: &str, text: &str| -> Vec<String> {
        let passages = passages(path, text);
        let hits = passages.iter().flat_map(hits);
        hits.map(|hit| format!("{} {}: {}", hit.line, hit.pattern, hit.text)).collect()
    };
    let source = "crates/effects/src/a.rs";
    let script = "crates/service/src/page/assets/a.js";
    for (path, right) in [
        (source, "// It is told.\nlet told = \"reported\"; /* told */"),
        (source, "/// told\n#[expect(dead_code, reason = \"told\")]\nfn a<'a>(b: &'a str) {}"),
        (source, "#[cfg(test)]\nmod tests { const A: &str = \"told\"; fn b() {} }\nconst B: &str = \"b\";"),
        (source, "format!(\"{told} and {tells:>4} '\\\"' {}\", '\"', 'a');"),
        (source, "json!({ \"lives\": 1 })"),
        (source, "\"noise-floor: the model is adequate\""),
        (source, "\"The error. Left, what? Enough.\""),
        ("crates/effects/src/a/tests.rs", "const A: &str = \"told\";"),
        ("docs/glossary.md", "told"),
        ("docs/README.md", "| adequate |\n|---|\n| enough |"),
        ("config/a.toml", "told = \"told\" # reported"),
        ("tests/a.rs", "\"told\""),
        (script, "// told\nconst told = `It ${told(`is ${\"said\"}`)} ends.`; /* told */"),
        ("docs/schemas/run.schema.json", "\"told\": { \"title\": \"told\" }"),
    ] {
        assert_eq!(found(path, right), [""; 0], "{right}");
    }
    for (path, wrong, expected) in [
        (source, "\n\"It is Told.\"", "2 told: It is Told."),
        (source, "r#\"It is \"told\".\"#", "1 told: It is \"told\"."),
        (source, "\"a \\\n  cannot\\nbe seen\"", "2 cannot be seen: a cannot be seen"),
        (source, "#[cfg(test)]\nmod tests;\nconst A: &str = \"Befallen.\";", "3 befall*: Befallen."),
        (source, "'\"'; \"enough\"", "1 enough: enough"),
        (source, "use clap::Args;\n/// It\n/// tells.", "3 tells: It tells."),
        (script, "\n\"It is told.\"", "2 told: It is told."),
        (script, "a(`It ${b(\"} tells\")} ends.`)", "1 tells: } tells"),
        (script, "`Many ${of} are\nalike`", "2 alike: Many {} are alike"),
        ("docs/README.md", "The error\nleft is 3.", "1 error left: The error left is 3."),
        ("docs/README.md", "| enough |\n|---|\n| 1 |", "1 enough: enough"),
        ("config/a.toml", "a = \"#\" # no\n# patience", "2 patience: no patience"),
        (source, "\"{} rms left ({});\"", "1 rms left: {} rms left ({});"),
        ("systemd/a.rules", "A=\"told\"\n# unless told otherwise", "2 told: unless told otherwise"),
        ("docs/schemas/run.schema.json", "{\n  \"description\": \"Told.\"", "2 told: Told."),
        (
            "crates/python/python/a.pyi",
            "def a(self) -> str:\n    \"\"\"Told.\"\"\"",
            "2 told: def a(self) -> str: \"\"\"Told.\"\"\"",
        ),
    ] {
        assert_eq!(found(path, wrong), [expected], "{wrong}");
    }
}

#[test]
fn a_replaced_word_in_a_name_is_found() {
    let found = |text: &str| -> Vec<String> {
        let names = names_of_rust(text);
        names.iter().flat_map(hits).map(|hit| format!("{} {}", hit.line, hit.pattern)).collect()
    };
    assert_eq!(found("let a = 1;\nfn is_told_apart() { ALIKE }"), ["2 told", "2 alike"]);
    assert_eq!(found("struct LineSurvey;"), ["1 survey*"]);
    assert_eq!(found("// told\nlet retold = \"told\"; let tolder = r#\"told\"#;"), [""; 0]);
}

/// What users read of a file; empty for any other file.
fn passages(path: &str, text: &str) -> Vec<Passage> {
    let top = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "ARCHITECTURE.md"];
    let below = |folder: &str| Path::new(path).starts_with(folder);
    if path == "docs/glossary.md" {
        return Vec::new();
    }
    let is_test = Path::new(path).iter().any(|part| part == "tests" || part == "tests.rs");
    let is_source = (below("crates") || below("hil-sim")) && path.contains("/src/") && !is_test;
    match Path::new(path).extension().and_then(|extension| extension.to_str()) {
        Some("rs") if is_source => of_rust(text),
        Some("js") if is_source => of_javascript(text),
        Some("md") if below("docs") || top.contains(&path) => of_markdown(text),
        Some("toml") if below("config") => of_toml(text),
        Some("json") if below("docs/schemas") => of_schema(text),
        // The stubs and the package are read with their names, which are words of the interface.
        Some("py" | "pyi") if below("crates/python") => of_markdown(text),
        _ if below("systemd") => of_toml(text),
        _ => Vec::new(),
    }
}

/// A word to replace.
struct Hit {
    line: usize,
    /// The words around it.
    text: String,
    pattern: &'static str,
    say: &'static str,
}

fn hits(passage: &Passage) -> Vec<Hit> {
    let whole = |pattern| Some((0, passage.words.len())).filter(|_| passage.is_head && passage.is(pattern));
    let heads = REPLACED_HEADS.iter().flat_map(|entry| whole(entry.0).map(|at| (entry, at)));
    let words =
        REPLACED.iter().flat_map(|entry| passage.find(entry.0).into_iter().map(move |at| (entry, at)));
    let hit = |(&(pattern, say), (at, length))| Hit {
        line: passage.line(at),
        text: passage.around(at, length),
        pattern,
        say,
    };
    heads.chain(words).map(hit).collect()
}
