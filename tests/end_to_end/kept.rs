//! What a command worked out, the next one takes from the folder of the program.

use crate::program::{answer, import};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a command prints, and what it says on the side, where it keeps in this folder; empty: nowhere.
fn keeping(folder: &Path, args: &[&str]) -> (String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
    let ran = command.args(args).env("COLUMNS", "1000").env("TRUNNION_CACHE_DIR", folder).output().unwrap();
    assert!(ran.status.success(), "{args:?}");
    (String::from_utf8(ran.stdout).unwrap(), String::from_utf8(ran.stderr).unwrap())
}

/// Every command that fits, in turn, with the model file that the last leaves; the model is not there before and after.
fn all(keeps: &Path, run: &str) -> Vec<(String, String)> {
    let model = Path::new(run).with_extension("model.toml");
    std::fs::remove_file(&model).ok();
    let model = model.to_str().unwrap();
    let mut said: Vec<(String, String)> = [
        vec!["diagnose", run, "--json"],
        vec!["compare", run, "--json"],
        vec!["compare", run, "--try", "gravity-sag:B", "--json"],
        vec!["add", "gravity-sag:B", run, "--model", model, "--json"],
        vec!["diagnose", run, "--model", model, "--json"],
        vec!["identify", run, "--model", model, "--json"],
        vec!["remove", "gravity-sag:B", run, "--model", model, "--json"],
    ]
    .iter()
    .map(|args| keeping(keeps, args))
    .collect();
    said.push((std::fs::read_to_string(model).unwrap(), String::new()));
    said
}

fn kept(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn commands_print_the_same_whether_what_they_need_is_kept_damaged_or_cannot_be_kept() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let worked_out = all(Path::new(""), &run);
    let keeps = folder.path().join("keeps");
    assert_eq!(all(&keeps, &run), worked_out, "kept on the way");
    let files = kept(&keeps);
    assert!(files.len() > 5, "{files:?}");
    assert_eq!(all(&keeps, &run), worked_out, "taken");
    assert_eq!(kept(&keeps), files, "nothing was worked out");

    for (k, file) in files.iter().enumerate() {
        let text = std::fs::read_to_string(file).unwrap();
        let damaged = match k % 3 {
            0 => text[..text.len() / 2].to_string(),
            // A digit of a number.
            1 => text.replace('7', "8"),
            _ => std::fs::read_to_string(&files[0]).unwrap(),
        };
        std::fs::write(file, damaged).unwrap();
    }
    assert_eq!(all(&keeps, &run), worked_out, "damaged");

    let no_folder = folder.path().join("file");
    std::fs::write(&no_folder, "").unwrap();
    assert_eq!(all(&no_folder, &run), worked_out, "cannot be kept");
    assert_eq!(std::fs::read_to_string(no_folder).unwrap(), "");
}

#[test]
fn a_diagnosis_is_taken_as_it_was_kept() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let keeps = folder.path().join("keeps");
    let diagnose = ["diagnose", run.as_str(), "--json"];
    let (before, _) = keeping(&keeps, &diagnose);
    // Whoever changes what is kept, and its digest, changes the answer: it was not worked out again.
    let is_diagnosis = |file: &&PathBuf| std::fs::read_to_string(file).unwrap().contains("\"not_visible\":");
    let files = kept(&keeps);
    let file = files.iter().find(is_diagnosis).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    let (head, body) = text.split_once('\n').unwrap();
    let body = body.replace("gravity-sag:B", "gravity-sag:A");
    let body_file = folder.path().join("body");
    std::fs::write(&body_file, &body).unwrap();
    let of = head.split_once(' ').unwrap().0;
    std::fs::write(file, format!("{of} {}\n{body}", trunnion::sha256(&body_file).unwrap())).unwrap();
    let (after, _) = keeping(&keeps, &diagnose);
    assert!(before.contains("gravity-sag:B") && !before.contains("gravity-sag:A\""));
    assert!(after.contains("gravity-sag:A\""), "{after}");
    // Another build of the program, or none that keeps, works it out.
    assert_eq!(String::from_utf8(answer(&diagnose).stdout).unwrap(), before);
}
