//! What a reader of hand-written files reports.

use super::*;

#[test]
fn every_problem_is_reported_at_once_with_its_line() {
    let text = "name = 3\n[probes]\nsilence_ms = 5\nsilense = 1\n";
    let document = Document::parse("trunnion.toml", text).unwrap();
    let root = document.root();
    let name = root.string("name");
    let probes = root.table("probes").unwrap();
    probes.number("silence_ms", 20.0..=10000.0);
    probes.no_other_keys();
    root.no_other_keys();
    let problems = document.finish(name).unwrap_err();
    let lines: Vec<_> = problems.0.iter().map(|p| (p.line, p.found.as_str())).collect();
    assert_eq!(
        lines,
        [(1, "name is integer"), (3, "probes.silence_ms = 5"), (4, "probes.silense is not known here")]
    );
    assert!(problems.to_string().contains("trunnion.toml:3:14: probes.silence_ms = 5; allowed: 20..=10000"));
}

#[test]
fn a_syntax_error_names_its_line() {
    let problems = Document::parse("machine.toml", "a = 1\nb = = 2\n").err().unwrap();
    assert_eq!((problems.0[0].line, problems.0[0].file.as_str()), (2, "machine.toml"));
}
