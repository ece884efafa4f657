//! Walks the registry of named methods and its directory: what every method must keep.

use std::collections::BTreeSet;
use std::path::Path;
use trunnion_core::Joint;
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::shipped;
use trunnion_methods::recipes;
use trunnion_methods::recipes::{Convention, MethodError, MethodOptions, REGISTRY};

const DIRECTORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/recipes");

fn empty_run(machine: &str) -> Run {
    let machine = shipped::machine(machine).expect("shipped");
    Run {
        name: "empty".into(),
        machine,
        kind: RunKind::Static,
        setups: vec![],
        channels: vec![],
        points: vec![],
    }
}

#[test]
fn every_file_of_the_directory_is_registered_under_its_name() {
    let paths = std::fs::read_dir(DIRECTORY).unwrap().map(|entry| entry.unwrap().path());
    // What all methods share.
    let leaves = ["convention", "method"];
    let files: BTreeSet<String> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "rs"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().replace('_', "-"))
        .filter(|name| !leaves.contains(&name.as_str()))
        .collect();
    let registered: Vec<String> = REGISTRY.iter().map(|method| method.name.into()).collect();
    assert_eq!(
        files,
        registered.iter().cloned().collect(),
        "left: the files of crates/methods/src/recipes, `-` for `_`; right: names of REGISTRY in crates/methods/src/recipes.rs"
    );
    assert_eq!(files.len(), registered.len(), "a method is registered twice");
}

#[test]
fn every_method_says_what_it_is_and_is_in_the_guide() {
    let guide =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/use/methods.md")).unwrap();
    for method in REGISTRY {
        let texts = [method.title, method.source, method.about, method.needs, method.gives];
        assert!(texts.iter().all(|text| text.len() > 10), "{}", method.name);
        let file = Path::new(DIRECTORY).join(format!("{}.rs", method.name.replace('-', "_")));
        let code = std::fs::read_to_string(file).unwrap();
        let header: String = code.lines().take_while(|line| line.starts_with("//!")).collect();
        assert!(header.contains("Limits:"), "{} states no limits", method.name);
        assert!(header.contains('['), "{} names no source", method.name);
        assert!(guide.contains(&format!("## {}", method.name)), "docs/use/methods.md lacks {}", method.name);
        assert!(guide.contains(&format!("--method {}", method.name)), "no command for {}", method.name);
        assert_eq!(recipes::find(method.name).unwrap().name, method.name);
    }
}

#[test]
fn every_method_is_tested_against_figures() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let folders = ["crates/methods/tests/all", "tests/tests/all/named_methods"];
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(Path::new(root).join(folder)).unwrap());
    let paths = files.map(|entry| entry.unwrap().path()).filter(|path| !path.ends_with("methods.rs"));
    let tests: Vec<String> = paths.map(|path| std::fs::read_to_string(path).unwrap()).collect();
    for method in REGISTRY {
        let (name, quoted) = (method.name, format!("\"{}\"", method.name));
        assert!(
            tests.iter().any(|test| test.contains(&quoted)),
            "no test finds {name}: write crates/methods/tests/all/{}.rs with figures that its source prints",
            name.replace('-', "_")
        );
    }
}

#[test]
fn an_unknown_name_is_answered_with_the_allowed_ones() {
    let error = recipes::find("two-hight").unwrap_err().to_string();
    assert!(error.contains("two-hight"), "{error}");
    assert!(REGISTRY.iter().all(|method| error.contains(method.name)), "{error}");
}

#[test]
fn a_method_without_data_says_what_it_needs() {
    for method in REGISTRY {
        let options = MethodOptions::default();
        assert!(matches!(method.apply(&[], &options), Err(MethodError::Runs(_))), "{}", method.name);
        let error = method.apply(&[empty_run("table-bc")], &options).unwrap_err().to_string();
        assert!(error.contains(method.name) && error.contains(method.needs), "{error}");
        let two = [empty_run("table-bc"), empty_run("table-ac")];
        assert!(matches!(method.apply(&two, &options), Err(MethodError::Runs(_))), "{}", method.name);
    }
}

#[test]
fn signs_of_a_source_are_never_asked_for_in_vain() {
    let without: Vec<_> = REGISTRY.iter().filter(|method| !method.takes_convention).collect();
    assert!(!without.is_empty());
    for method in without {
        let options = MethodOptions { convention: Convention::Source, ..MethodOptions::default() };
        let error = method.apply(&[empty_run("table-bc")], &options).unwrap_err().to_string();
        assert!(error.contains(method.name) && error.contains("leave out the convention"), "{error}");
    }
}

#[test]
fn an_axis_is_never_asked_for_in_vain() {
    for method in REGISTRY.iter().filter(|method| !method.takes_axis) {
        let options = MethodOptions { axis: Some(Joint::C), ..MethodOptions::default() };
        let error = method.apply(&[empty_run("table-bc")], &options).unwrap_err().to_string();
        assert!(error.contains(method.name) && error.contains("leave out the axis C"), "{error}");
    }
}
