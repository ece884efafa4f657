//! Samples that are missing from the recordings of a run without a gap that says so.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_core::Gap;
use trunnion_core::statistics::upper_median;
use trunnion_machine::shipped;

/// A gap of the recorder begins and ends with a message, which holds the samples of up to [`trunnion_record::BATCH_AGE`]: one more or less at
/// either end.
const NEAR_S: f64 = 2.0 * trunnion_record::BATCH_AGE.as_millis() as f64 * 1e-3;
/// Source of the gaps of the recorder, which are of every channel.
const RECORDER: &str = "recorder";
/// A hole is longer than so many usual steps.
const HOLE_STEPS: f64 = 10.0;

/// A time without samples of a probe that no gap says.
#[derive(Debug)]
pub struct Hole {
    /// Run and probe.
    of: String,
    /// On the wall clock, ns since 1970.
    pub from_ns: i64,
    pub length: Duration,
}

impl fmt::Display for Hole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {:.0} ms", self.of, self.length.as_secs_f64() * 1e3)
    }
}

/// Every gap of some recordings, and holes between samples of a probe that no gap covers.
pub fn gaps_and_silent_losses(files: &[PathBuf]) -> (Vec<Gap>, Vec<Hole>) {
    let mut parts: BTreeMap<String, Vec<&PathBuf>> = BTreeMap::new();
    files.iter().for_each(|file| parts.entry(run(file)).or_default().push(file));
    let (mut all_gaps, mut silent) = (Vec::new(), Vec::new());
    for (name, files) in parts {
        let mut channels: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        let (mut gaps, mut began_ns) = (Vec::new(), 0);
        for file in files {
            let run = trunnion_record::read_run(file, &shipped::machine).unwrap();
            began_ns = run.header.wall_start_ns;
            for sample in &run.probe_samples {
                let probe = &run.header.probes[usize::from(sample.channel)];
                channels.entry(probe.clone()).or_default().push(sample.time_s);
            }
            gaps.extend(run.gaps);
        }
        for (probe, times_s) in channels {
            silent.extend(holes(times_s, &probe, &gaps).into_iter().map(|(from_s, to_s)| Hole {
                of: format!("{name}, {probe}: {from_s:.3} s to {to_s:.3} s"),
                from_ns: began_ns + (from_s * 1e9) as i64,
                length: Duration::from_secs_f64(to_s - from_s),
            }));
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

/// Holes between samples of a probe, s, that no gaps of it or of the recorder cover from end to end.
fn holes(mut times_s: Vec<f64>, probe: &str, gaps: &[Gap]) -> Vec<(f64, f64)> {
    times_s.sort_by(f64::total_cmp);
    let steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual_s = upper_median(&steps).unwrap_or(0.0);
    let mut gaps: Vec<&Gap> =
        gaps.iter().filter(|gap| gap.source == probe || gap.source == RECORDER).collect();
    gaps.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    let is_covered = |from_s: f64, to_s: f64| {
        let reach = |covered_s: f64, gap: &&Gap| match gap.from_s <= covered_s + NEAR_S {
            true => covered_s.max(gap.to_s),
            false => covered_s,
        };
        let mut near = gaps.iter().filter(|gap| gap.to_s >= from_s - NEAR_S && gap.from_s <= to_s).peekable();
        near.peek().is_some() && near.fold(from_s, reach) >= to_s - NEAR_S
    };
    let between = times_s.windows(2).map(|pair| (pair[0], pair[1]));
    let is_hole = |&(from_s, to_s): &(f64, f64)| to_s - from_s > HOLE_STEPS * usual_s;
    between.filter(|hole| is_hole(hole) && !is_covered(hole.0, hole.1)).collect()
}

#[test]
fn a_hole_is_silent_unless_gaps_of_its_probe_or_of_the_recorder_cover_it() {
    let times_s: Vec<f64> =
        (0..3000).filter(|k| !(1000..1500).contains(k)).map(|k| f64::from(k) * 1e-3).collect();
    let gap = |source: &str, from_s, to_s| Gap {
        source: source.into(),
        from_s,
        to_s,
        lost_samples: None,
        reason: String::new(),
    };
    let found = |gaps: &[Gap]| holes(times_s.clone(), "probe-1", gaps);
    let silent = found(&[gap("probe-1", 2.5, 2.6)]);
    assert_eq!(silent.len(), 1);
    assert!((silent[0].0 - 0.999).abs() < 1e-9 && (silent[0].1 - 1.5).abs() < 1e-9, "{silent:?}");
    assert_eq!(found(&[gap("probe-1", 0.99, 1.01)]).len(), 1, "its beginning alone");
    assert_eq!(found(&[gap("probe-2", 1.0, 1.5)]).len(), 1, "another probe");
    assert_eq!(found(&[gap("probe-1", 1.0, 1.5)]), []);
    assert_eq!(found(&[gap("recorder", 0.5, 1.2), gap("probe-1", 1.2, 1.5)]), []);
    // A message at either end is near, more is not.
    assert_eq!(found(&[gap("recorder", 1.05, 1.45)]), []);
    assert_eq!(found(&[gap("recorder", 1.09, 1.5)]).len(), 1);
    assert_eq!(run(Path::new("demo-20261125T224237Z-2.mcap")), "demo-20261125T224237Z");
    assert_eq!(run(Path::new("demo-20261125T224237Z-joined.mcap")), "demo-20261125T224237Z-joined");
}
