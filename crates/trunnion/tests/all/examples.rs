//! The examples of the library end well on the committed run.

use std::path::PathBuf;
use std::process::Command;

/// What an example prints; `cargo test` builds the examples of a crate next to its tests.
fn printed(example: &str) -> String {
    let tests = std::env::current_exe().unwrap();
    let program: PathBuf = tests.parent().unwrap().parent().unwrap().join("examples").join(example);
    let output = Command::new(&program).output().unwrap_or_else(|why| {
        panic!("{}: {why}; `cargo build -p trunnion --examples` builds it", program.display())
    });
    assert!(output.status.success(), "{example}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn diagnose_names_the_missing_effect() {
    assert!(printed("diagnose").contains("gravity-sag:B"));
}

#[test]
fn ladder_ends_with_a_ladder_that_can_be_read() {
    let text = printed("ladder");
    let json = &text[text.find('{').unwrap()..];
    let ladder: trunnion::results::Ladder = serde_json::from_str(json).unwrap();
    let added: Vec<_> = ladder.rows.iter().filter(|row| row.ladder.is_some()).collect();
    assert_eq!(added[0].effect, "gravity-sag:B");
}

#[test]
fn predict_ends_with_a_prediction_that_can_be_read() {
    let prediction: trunnion::results::Prediction = serde_json::from_str(&printed("predict")).unwrap();
    assert!(prediction.runs[0].inside_95_fraction > 0.9);
}
