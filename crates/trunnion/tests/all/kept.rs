//! What a history worked out is kept, and taken again as long as it is of the same.

use crate::forecast::run;
use std::path::{Path, PathBuf};
use trunnion::Model;
use trunnion::history::{Keeper, Wanted, filed, history};
use trunnion::results::{MachineHistory, to_json};

const DAYS: usize = 5;

fn days(folder: &Path) -> Vec<Vec<PathBuf>> {
    (1..=DAYS).map(|day| run(folder, day, 1)).collect()
}

/// A history as JSON, in which every bit of a number shows; what was worked out for it; why something was not kept.
fn worked_out(runs: &[Vec<PathBuf>], model: Option<&Model>) -> (String, Vec<String>, Option<String>) {
    let mut parts = Vec::new();
    let wanted = Wanted { model: model.cloned(), ..Wanted::default() };
    let mut keeper = Keeper::new(|working| parts.push(working.what.to_owned()));
    let answer: MachineHistory = history(runs, &wanted, &mut keeper).unwrap();
    let not_kept = keeper.not_kept().map(|failure| trunnion::chain(failure));
    drop(keeper);
    (to_json(&answer).unwrap(), parts, not_kept)
}

#[test]
fn a_history_is_the_same_to_the_bit_kept_or_worked_out_and_never_of_other_files_or_another_model() {
    let folder = tempfile::tempdir().unwrap();
    let runs = days(folder.path());
    let (first, parts, not_kept) = worked_out(&runs, None);
    assert_eq!((parts.len(), not_kept), (DAYS + 2, None), "{parts:?}");
    assert!(first.contains("\"checked\": {") && first.contains("\"change\": {"), "{first}");
    let (again, parts, _) = worked_out(&runs, None);
    assert_eq!((again, parts), (first.clone(), vec![]));

    // The fourth day once more under the name of the last: four days are too few for a forecast.
    std::fs::copy(&runs[3][0], &runs[4][0]).unwrap();
    let (other, parts, _) = worked_out(&runs, None);
    assert_eq!(parts, ["day-5-of-1-0", "what changed"]);
    assert_ne!(other, first);

    let mut fixed = Model::base("table-bc").text().replacen(
        "id = \"location-errors\"",
        "id = \"location-errors\"\nfixed = { EX0B = 0.0 }",
        1,
    );
    fixed += "# by hand\n";
    let model = Model::parse("m.toml", fixed).unwrap();
    let (of_model, parts, _) = worked_out(&runs, Some(&model));
    assert_eq!(parts.len(), DAYS + 1, "{parts:?}");
    assert_ne!(of_model, other);
    // Both are kept.
    assert_eq!(worked_out(&runs, None), (other, vec![], None));
    assert_eq!(worked_out(&runs, Some(&model)), (of_model, vec![], None));
}

#[test]
fn what_an_analysis_files_is_what_a_history_works_out() {
    let folder = tempfile::tempdir().unwrap();
    let runs = vec![run(folder.path(), 1, 2)];
    let (worked, parts, _) = worked_out(&runs, None);
    assert_eq!(parts, ["day-1-of-2-0"]);
    let kept = runs[0][0].with_extension("history.jsonl");
    std::fs::remove_file(&kept).unwrap();
    let place = filed(&runs[0], None);
    let experiment = trunnion::open_runs(&runs).unwrap();
    place.keep(&experiment.fit(&experiment.base_model()).unwrap().diagnose().unwrap()).unwrap();
    assert_eq!(worked_out(&runs, None), (worked, vec![], None));
}

#[test]
fn a_folder_that_takes_nothing_costs_no_history_and_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    let runs = vec![run(folder.path(), 1, 1), run(folder.path(), 2, 1)];
    for run in &runs {
        // No file takes the place of a folder, whoever asks.
        std::fs::create_dir(run[0].with_extension("history.jsonl")).unwrap();
    }
    let (answer, _, not_kept) = worked_out(&runs, None);
    assert!(answer.contains("\"change\": {"), "{answer}");
    assert!(not_kept.unwrap().contains("day-1-of-1-0.history.jsonl"), "the first");
}
