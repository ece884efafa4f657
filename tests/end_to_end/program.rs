//! The program, run as a person would.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// What the program works out in these tests, empty when they begin: a question that two of them ask, or one of them twice, is worked out once,
/// as for its user. It is half of their time.
static KEPT: LazyLock<&Path> = LazyLock::new(|| {
    let folder = Path::new(concat!(env!("CARGO_TARGET_TMPDIR"), "/end-to-end-kept"));
    if folder.exists() {
        std::fs::remove_dir_all(folder).expect("the folder of the build loses folders");
    }
    std::fs::create_dir_all(folder).expect("the folder of the build takes folders");
    folder
});

/// `trunnion`.
pub fn command() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
    command.env("TRUNNION_CACHE_DIR", *KEPT);
    command
}

/// Runs `trunnion`.
pub fn answer(args: &[&str]) -> Output {
    let mut command = command();
    // Sentences are searched for in one piece.
    command.args(args).env("COLUMNS", "1000").output().expect("the program starts")
}

/// The same: whether it exits with 0, standard output, standard error.
pub fn output(args: &[&str]) -> (bool, String, String) {
    let output = answer(args);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("it writes UTF-8");
    (output.status.success(), text(output.stdout), text(output.stderr))
}

/// Standard output of a run that must exit with 0.
pub fn trunnion(args: &[&str]) -> String {
    let (done, stdout, stderr) = output(args);
    assert!(done, "{args:?}: {stderr}");
    stdout
}

/// Standard error of a run that must not exit with 0.
pub fn refused(args: &[&str]) -> String {
    let (done, stdout, stderr) = output(args);
    assert!(!done, "{args:?} was not refused: {stdout}");
    stderr
}

/// Standard output as JSON.
pub fn json(args: &[&str]) -> Value {
    serde_json::from_str(&trunnion(args)).expect("it writes JSON")
}

/// Writes a file into `folder`: its path.
pub fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("the folder takes files");
    path.display().to_string()
}

/// A folder of the outside data.
pub fn data(set: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data")).join(set)
}

/// Imports points of the outside data into `folder`: the recording.
pub fn import(set: &str, folder: &Path) -> String {
    let run = folder.join("run.mcap").display().to_string();
    let file = |name: &str| data(set).join(name).display().to_string();
    trunnion(&["import", &file("points.csv"), "--setup", &file("setup.toml"), "-o", &run]);
    run
}

/// The same, and a model to which an effect is added: recording and model.
pub fn import_and_add(set: &str, effect: &str, folder: &Path) -> (String, String) {
    let run = import(set, folder);
    let model = folder.join("model.toml").display().to_string();
    trunnion(&["add", effect, &run, "--model", &model]);
    (run, model)
}
