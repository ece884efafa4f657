//! Single readings that a long run on the fly loses on the way to its blocks are said, and doubted where they are many.

use std::path::{Path, PathBuf};
use trunnion::Filing;
use trunnion::results::{DoubtReason, to_json};
use trunnion_core::axis::iso::C;
use trunnion_core::{Point, Quality, State};
use trunnion_cycles::{Cycle, Pace};
use trunnion_machine::shipped;
use trunnion_record::{RunHeader, RunWriter};

const CYCLE: &str = include_str!("../../../../config/cycles/demo-sweep-c.toml");
const LONE: &str = "single readings far from their neighbours";

/// A sweep of 400 points a second; with `backwards_um` every tenth reading of the passes back is so far off, alone.
fn swept(path: &Path, backwards_um: f64) -> PathBuf {
    let machine = shipped::machine("table-bc").unwrap();
    let cycle = Cycle::parse("sweep.toml", CYCLE).unwrap();
    let pace = Pace { points_per_s: 400.0, ..Pace::default() };
    let states = cycle.visits(&machine, &pace).unwrap().states;
    let header: RunHeader = crate::header("swept", CYCLE);
    let header = RunHeader {
        kind: cycle.run_kind(),
        setups: cycle.setups.clone(),
        cycle_text: String::new(),
        ..header
    };
    let mut writer = RunWriter::create(path, &header).unwrap();
    for (i, state) in states.into_iter().enumerate() {
        let scatter = |k: usize| 1e-3 * (uniform((3 * i + k) as u64) - 0.5);
        let is_off = state.direction[C] < 0.0 && i % 10 == 0;
        let off_mm = if is_off { 1e-3 * backwards_um } else { 0.0 };
        writer.point(Point {
            state: State { ..state },
            reading_mm: [scatter(1) + off_mm, scatter(2), scatter(3)],
            spread_mm: [0.0; 3],
            samples: 1,
            quality: Quality::Good,
        });
    }
    writer.finish().unwrap();
    path.into()
}

/// A number from 0 to 1 that looks drawn: neighbours have nothing in common (SplitMix64).
fn uniform(index: u64) -> f64 {
    let mut z = index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn many_lone_readings_are_a_doubt_on_every_surface() {
    let folder = tempfile::tempdir().unwrap();
    let path = swept(&folder.path().join("swept.mcap"), 80.0);
    let run = trunnion::open(&path).unwrap();
    let fit = run.fit(&run.base_model()).unwrap();
    let doubts = fit.results().doubts;
    let doubt = doubts.iter().find(|doubt| doubt.reason == DoubtReason::LoneReadings).expect("a doubt");
    // Where, how many, what to do.
    for said in ["setup low, C back at", "(5.", "Look for chips"] {
        assert!(doubt.words.contains(said), "{said}: {}", doubt.words);
    }
    let compared = fit.compare();
    let filed = compared.report(std::slice::from_ref(&path), &Filing::default()).unwrap();
    let filed = trunnion::report::report_html(&filed, trunnion::report::Language::English);
    let json = to_json(&fit.results()).unwrap();
    let check = trunnion::report::check_text(&run.check());
    let surfaces = [
        ("identify", fit.summary()),
        ("diagnose", fit.diagnose().unwrap().summary()),
        ("compare", compared.summary()),
        ("page", compared.page()),
        ("filed", filed),
        ("check", check),
        ("JSON", json.clone()),
    ];
    for (name, text) in surfaces {
        assert!(words(&text).contains("lie far from their neighbours and are excluded"), "{name}: {text}");
    }
    // They are among what is excluded too.
    assert!(
        run.check().complete.excluded.iter().any(|part| part.reason == LONE && part.count > 100),
        "{json}"
    );
}

#[test]
fn a_run_without_lone_readings_raises_no_doubt() {
    let folder = tempfile::tempdir().unwrap();
    let run = trunnion::open(swept(&folder.path().join("swept.mcap"), 0.0)).unwrap();
    let check = run.check();
    assert!(check.doubts.is_empty() && check.complete.excluded.is_empty(), "{check:?}");
    assert_eq!(run.reductions().len(), 1, "it is long enough to be reduced");
}
