//! What changed from one run to the next.

use crate::mistakes::{Files, READINGS};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use trunnion::history::{Keeper, changed};

/// The points of a run, written into a folder of their own.
fn written(files: &Files, folder: &Path, name: &str) -> Vec<PathBuf> {
    let own = folder.join(name);
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("setup.toml"), &files.setup).unwrap();
    std::fs::write(own.join("points.csv"), files.text()).unwrap();
    vec![own.join("points.csv")]
}

/// Readings that scatter ten times as much are no change of a value: those of the day itself fit them no better.
#[test]
fn a_run_that_only_scatters_more_is_not_said_to_differ_from_what_the_values_predict() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Files::committed("points-nothing-hidden");
    let model = files.open().base_model();
    let earlier = written(&files, folder.path(), "earlier");
    let state = Cell::new(7_u64);
    for reading in READINGS {
        files.change(reading, |um| {
            state.set(
                state.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407),
            );
            um + 10.0 * ((state.get() >> 33) as f64 / (1_u64 << 31) as f64 - 0.5)
        });
    }
    let later = written(&files, folder.path(), "later");
    let change = changed([earlier, later], &model, &mut Keeper::default()).unwrap();
    let words = change.words.join(" ");
    assert!(words.contains("No value changed significantly: values of its own fit"), "{words}");
    assert!(words.contains("The model leaves more") && !words.contains("differs"), "{words}");
}
