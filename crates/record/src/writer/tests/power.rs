//! The power fails at any moment: what the disk has then is read, and what it has not is no more than a tenth of a second.
//!
//! Of the file the disk has what the last finished sync had brought it, and any part of what was written since, as it was or as zeros.

use super::*;
use crate::finish::recover_orphans;
use crate::syncs::{AT_RISK, Syncs};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Readings of three probes, 1/s.
const RATE: i64 = 12_000;
const STEP_NS: i64 = 1_000_000_000 / RATE;
/// The slowest sync of the disks that were tried, ms (docs/design/numerics.md §2).
const SLOWEST_MS: f64 = 37.0;

/// A run on a disk whose syncs take as long as `took` says, ms; when each ended, what it brought and all that was written.
struct Powered {
    /// Moment and size of what was safe from then on.
    safe: Vec<(HostTime, u64)>,
    written: Vec<u8>,
    at_risk: Duration,
}

impl Powered {
    /// The thread of the recorder takes readings as they arrive, and those that waited when it is free again.
    fn run(seconds: i64, mut took_ms: impl FnMut() -> f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::create(folder.path(), "power", &header("power")).unwrap();
        let journal = folder.path().join("power.mcap.active");
        let size = || std::fs::metadata(&journal).unwrap().len();
        let mut safe = vec![(HostTime(0), size())];
        let mut syncs = Syncs::begin(HostTime(0));
        let mut free_at = HostTime(0);
        for k in 0..seconds * RATE {
            let arrival = HostTime(k * STEP_NS);
            let now = arrival.max(free_at);
            let raw = k / 3;
            let (channel, value_mm) = ((k % 3) as u16, (raw as f64).sin());
            let time_s = arrival.seconds_since(HostTime(0));
            let sample = ProbeSample { channel, time_s, raw, value_mm, ..ProbeSample::default() };
            recorder.append(Item::Probe(sample), arrival);
            if syncs.is_due(now) {
                assert!(recorder.sync(now));
                free_at = now + Duration::from_secs_f64(took_ms() * 1e-3);
                syncs.done(now, free_at, true);
                safe.push((free_at, size()));
            }
        }
        Self { safe, written: std::fs::read(&journal).unwrap(), at_risk: syncs.at_risk() }
    }

    /// How long before the cut the last sample is of all that was accepted before it, without a hole.
    fn lost_s(&self, cut: HostTime, rest: &mut impl FnMut(u64, &[u8]) -> Vec<u8>) -> f64 {
        let size = self.safe.iter().rev().find(|(at, _)| *at <= cut).unwrap().1;
        let (kept, unsafe_part) = self.written.split_at(usize::try_from(size).unwrap());
        let folder = tempfile::tempdir().unwrap();
        let mut journal = kept.to_vec();
        journal.extend(rest(size, unsafe_part));
        std::fs::write(folder.path().join("power.mcap.active"), journal).unwrap();
        let recovered = recover_orphans(folder.path()).unwrap().pop().unwrap().finished.unwrap();
        let read = read_run(&recovered.path, &shipped::machine).unwrap();
        let mut raws: Vec<[bool; 3]> = Vec::new();
        for sample in &read.probe_samples {
            let raw = usize::try_from(sample.raw).unwrap();
            raws.resize(raws.len().max(raw + 1), [false; 3]);
            raws[raw][usize::from(sample.channel)] = true;
        }
        let whole = raws.iter().take_while(|of| of.iter().all(|is_there| *is_there)).count();
        cut.seconds_since(HostTime(0)) - whole as f64 * 3.0 / RATE as f64
    }
}

#[test]
fn a_power_cut_at_any_moment_costs_no_more_than_a_tenth_of_a_second() {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    // From a quick disk to one that is always as slow as the slowest.
    let (mut worst_s, mut cuts) = (0.0_f64, 0);
    for from_ms in [0.1, 10.0, SLOWEST_MS - 0.1] {
        let run = Powered::run(2, || rng.random_range(from_ms..SLOWEST_MS));
        assert!(run.at_risk <= AT_RISK, "{:?} from {from_ms} ms", run.at_risk);
        for _ in 0..40 {
            let cut = HostTime(rng.random_range(0..1_990_000_000));
            let (share, zeros) = (rng.random_range(0.0..1.0), rng.random_bool(0.5));
            let mut rest = |_: u64, written: &[u8]| {
                let part = &written[..(written.len().min(60_000) as f64 * share) as usize];
                if zeros { vec![0; part.len()] } else { part.to_vec() }
            };
            worst_s = worst_s.max(run.lost_s(cut, &mut rest));
            worst_s = worst_s.max(run.lost_s(cut, &mut |_, _| Vec::new()));
            cuts += 2;
        }
    }
    println!("{cuts} cuts, at most {:.0} ms lost", worst_s * 1e3);
    assert!(worst_s <= AT_RISK.as_secs_f64(), "{worst_s}");
}

#[test]
fn a_disk_that_is_slower_says_what_a_power_cut_costs() {
    let run = Powered::run(2, || 300.0);
    let cuts = (0..40).map(|k| HostTime(k * 49_000_000));
    let worst_s = cuts.map(|cut| run.lost_s(cut, &mut |_, _| Vec::new())).fold(0.0, f64::max);
    assert!(worst_s > AT_RISK.as_secs_f64(), "this disk is not slow: {worst_s}");
    assert!(worst_s <= run.at_risk.as_secs_f64(), "{worst_s} and {:?}", run.at_risk);
}
