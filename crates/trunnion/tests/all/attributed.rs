//! Which axis made a deviation, of recordings that are not what they say they are.

use crate::mistakes::Files;

/// Points hold no positions of axes over time: of doubted ones that is not the first thing to say.
#[test]
fn attribution_answers_a_doubted_recording_with_the_doubt() {
    let folder = tempfile::tempdir().unwrap();
    let attributed = |name: &str, files: &Files| {
        let [points, setup, run] = ["points.csv", "setup.toml", name].map(|file| folder.path().join(file));
        std::fs::write(&points, files.text()).unwrap();
        std::fs::write(&setup, &files.setup).unwrap();
        trunnion::tables::import(trunnion::cycles::RunKind::Static, &points, &setup, &run).unwrap();
        trunnion::attribute_run(&run, 1.0, false)
    };
    let mut files = Files::committed("points-gravity");
    let refused = attributed("good.mcap", &files).err().unwrap();
    assert!(refused.to_string().contains("holds 0 axis positions"), "{refused}");
    files.change("dy_um", |um| -um);
    let found = attributed("doubted.mcap", &files).unwrap().findings;
    assert!(found.plausibility[0].hypothesis.contains("sign of the readings dy reversed"), "{found:?}");
    assert!(found.values.is_empty() && found.notes[0].contains("Not evaluated: "), "{found:?}");
}
