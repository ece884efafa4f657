//! Samples that are missing from the recordings of a run without a gap that says so.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion_core::Gap;
use trunnion_machine::shipped;

/// A gap may be noted so much earlier or later than the samples next to it: a batch.
const NEAR_S: f64 = 0.3;
/// A hole is longer than so many usual steps.
pub const HOLE_STEPS: f64 = 10.0;

/// Every gap of some recordings, and holes between samples of a probe that no gap covers.
pub fn gaps_and_silent_losses(files: &[PathBuf]) -> (Vec<Gap>, Vec<String>) {
    let mut parts: BTreeMap<String, Vec<&PathBuf>> = BTreeMap::new();
    files.iter().for_each(|file| parts.entry(run(file)).or_default().push(file));
    let (mut all_gaps, mut silent) = (Vec::new(), Vec::new());
    for (name, files) in parts {
        let mut channels: BTreeMap<u16, Vec<f64>> = BTreeMap::new();
        let mut gaps = Vec::new();
        for file in files {
            let run = trunnion_record::read_run(file, &shipped::machine).unwrap();
            run.probe_samples
                .iter()
                .for_each(|sample| channels.entry(sample.channel).or_default().push(sample.time_s));
            gaps.extend(run.gaps);
        }
        for (channel, times_s) in channels {
            let holes = holes(times_s, &gaps);
            silent.extend(
                holes.iter().map(|(from, to)| format!("{name}, channel {channel}: {from:.3} s to {to:.3} s")),
            );
        }
        all_gaps.extend(gaps);
    }
    (all_gaps, silent)
}

/// The run of a file: `NAME-2.mcap` is the second part of `NAME`, on the same time line.
fn run(file: &Path) -> String {
    let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
    match stem.rsplit_once('-') {
        Some((run, part)) if part.chars().all(|sign| sign.is_ascii_digit()) => run.into(),
        _ => stem,
    }
}

/// Holes between samples, s, that no gap covers.
fn holes(mut times_s: Vec<f64>, gaps: &[Gap]) -> Vec<(f64, f64)> {
    times_s.sort_by(f64::total_cmp);
    let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let usual_s = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let is_told = |from_s: f64, to_s: f64| {
        gaps.iter().any(|gap| gap.from_s < to_s + NEAR_S && gap.to_s > from_s - NEAR_S)
    };
    let holes = times_s.windows(2).map(|pair| (pair[0], pair[1]));
    holes.filter(|&(from_s, to_s)| to_s - from_s > HOLE_STEPS * usual_s && !is_told(from_s, to_s)).collect()
}

#[test]
fn a_hole_is_silent_unless_a_gap_covers_it() {
    let times_s: Vec<f64> =
        (0..3000).filter(|k| !(1000..1500).contains(k)).map(|k| f64::from(k) * 1e-3).collect();
    let gap = |from_s, to_s| Gap {
        source: "probe-1".into(),
        from_s,
        to_s,
        lost_samples: None,
        reason: String::new(),
    };
    let found = holes(times_s.clone(), &[gap(2.5, 2.6)]);
    assert_eq!(found.len(), 1);
    assert!((found[0].0 - 0.999).abs() < 1e-9 && (found[0].1 - 1.5).abs() < 1e-9, "{found:?}");
    assert_eq!(holes(times_s, &[gap(1.0, 1.5)]), []);
    assert_eq!(run(Path::new("demo-20261125T224237Z-2.mcap")), "demo-20261125T224237Z");
    assert_eq!(run(Path::new("demo-20261125T224237Z-joined.mcap")), "demo-20261125T224237Z-joined");
}
