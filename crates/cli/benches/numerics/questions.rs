//! What a person asks of a run one after the other, each time by a command.

use crate::recording;
use std::path::{Path, PathBuf};
use std::process::Command;

const EFFECT: &str = "gravity-sag:B";

/// The recording in a folder, and where nothing is kept.
pub fn asked(folder: &Path) -> Box<dyn FnOnce() -> String> {
    answers(recording(folder), PathBuf::new())
}

/// The same with what was worked out kept next to it.
pub fn kept(folder: &Path) -> Box<dyn FnOnce() -> String> {
    answers(recording(folder), folder.join("keeps"))
}

fn answers(run: PathBuf, keeps: PathBuf) -> Box<dyn FnOnce() -> String> {
    let model = run.with_extension("model.toml");
    std::fs::remove_file(&model).ok();
    let trunnion = move |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
        let ran = command.args(args).arg(&run).env("TRUNNION_CACHE_DIR", &keeps).output().unwrap();
        assert!(ran.status.success(), "{args:?}: {}", String::from_utf8_lossy(&ran.stderr));
        ran.stdout.len()
    };
    Box::new(move || {
        let model = model.to_str().unwrap();
        let bytes = trunnion(&["compare"])
            + trunnion(&["compare", "--try", EFFECT])
            + trunnion(&["add", EFFECT, "--model", model]);
        format!("3 answers, {bytes} bytes")
    })
}
