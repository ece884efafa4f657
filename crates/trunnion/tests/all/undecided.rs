//! Data that cannot decide between causes say so, and what to measure next.

use std::path::PathBuf;
use trunnion::Experiment;
use trunnion::results::{Goal, Verdict};
use trunnion_cycles::Cycle;

/// The committed run without a hidden effect, readings changed; the passes backwards of these setups read `um` more along Y of the table.
fn with_offset_of_a_pass(setups: &[&str], um: f64) -> (tempfile::TempDir, Experiment) {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-nothing-hidden");
    let text = std::fs::read_to_string(data.join("points.csv")).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|cell| *cell == name).unwrap();
    let [setup, direction, dy] = ["setup", "direction_c", "dy_um"].map(column);
    let mut changed = head.join(",");
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if cells[direction].parse::<f64>().unwrap() < 0.0 && setups.contains(&cells[setup].as_str()) {
            cells[dy] = format!("{:.4}", cells[dy].parse::<f64>().unwrap() + um);
        }
        changed += &format!("\n{}", cells.join(","));
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), changed + "\n").unwrap();
    std::fs::copy(data.join("setup.toml"), folder.path().join("setup.toml")).unwrap();
    let run = trunnion::open(folder.path().join("points.csv")).unwrap();
    (folder, run)
}

#[test]
fn two_passes_that_differ_are_undecided_and_the_cycle_that_decides_is_named() {
    // Along the circle that C carries the ball on, as a backlash of C does.
    let (_folder, run) = with_offset_of_a_pass(&["low", "high"], 0.3);
    let diagnosed = run.fit(&run.base_model()).unwrap().diagnose().unwrap();
    let answer = diagnosed.results();
    assert_eq!(answer.verdict, Verdict::Undecided, "{answer:?}");
    assert_eq!(answer.undecided[0].effect, "backlash:C", "{:?}", answer.undecided);
    assert!(answer.why.contains("backlash:C") && answer.why.contains("offsets of passes"), "{}", answer.why);
    let next = answer.next_cycle.unwrap();
    assert!(next.suggestion.starts_with("Repeat this pass"), "{next:?}");
    let planned = next.cycle.unwrap();
    // `plan` says the same first, and what the present cycle hides after it.
    let plan = diagnosed.fit().plan(&[]).unwrap().unwrap();
    assert_eq!(plan.goal, Goal::Repeat);
    assert!(plan.answer.starts_with(&next.suggestion), "{}", plan.answer);
    assert_eq!(
        plan.next.map(|next| (next.name, next.cycle)),
        Some((planned.name.clone(), planned.file.clone()))
    );
    assert!(!plan.effects.is_empty() && !plan.considered.is_empty());
    assert!(planned.separates.is_empty() && planned.separation.is_none(), "{planned:?}");
    let cycle = Cycle::parse("next.toml", &planned.file).unwrap();
    assert_eq!(cycle.poses(run.machine()).unwrap().len(), 336, "every pose in both directions");
    let text = diagnosed.summary().replace('\n', " ");
    assert!(text.contains("Repeat this pass") && text.contains("the present poses once more"), "{text}");
}

/// What only one setup shows is neither backlash nor drift to the search, and offsets of passes are noise to it. The larger, the less may
/// be called noise.
#[test]
fn no_offset_of_a_pass_is_large_enough_for_a_plain_all_clear() {
    for um in [1.2, 2.4, 4.8] {
        let (_folder, run) = with_offset_of_a_pass(&["low"], um);
        let diagnosed = run.fit(&run.base_model()).unwrap().diagnose().unwrap();
        let answer = diagnosed.results();
        let text = diagnosed.summary().split_whitespace().collect::<Vec<_>>().join(" ");
        match answer.verdict {
            Verdict::NoiseFloor => assert!(text.contains("passes differ by some"), "{um}: {text}"),
            Verdict::Undecided => assert!(text.contains("Repeat this pass"), "{um}: {text}"),
            Verdict::MissingEffect | Verdict::UnnamedStructure => {}
            Verdict::NotJudged => panic!("{um}: {text}"),
        }
        assert!(um < 2.0 || answer.verdict != Verdict::NoiseFloor, "{um}: {text}");
    }
}
