//! Room on the file system, and what a cycle needs of it.

use nix::sys::statvfs::statvfs;
use std::fmt;
use std::path::Path;

/// Journal and finished file of one reading, bytes: both are there until the journal goes. A journal of three probes at 1 kHz takes
/// 12 bytes a reading with its plots, the finished file 3 (test `a_reading_takes_no_more_room_than_is_asked_for`); the rest is for values
/// that compress worse.
pub const BYTES_A_READING: f64 = 40.0;
/// Machine and cycle file, points, events, page and JSON of a run, MB.
const OTHER_FILES_MB: f64 = 5.0;

/// What a cycle needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// Readings of all devices, 1/s.
    pub readings_per_s: f64,
    /// How long it lasts, s.
    pub cycle_s: f64,
}

impl Need {
    /// No cycle is about to begin.
    pub const NOTHING: Self = Self { readings_per_s: 0.0, cycle_s: 0.0 };

    /// On the file system, MB.
    pub fn mb(self) -> f64 {
        if self == Self::NOTHING {
            return 0.0;
        }
        OTHER_FILES_MB + self.readings_per_s * self.cycle_s * BYTES_A_READING / 1e6
    }
}

/// Whether there is room for a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Room {
    /// For it and for the rest of the computer.
    Enough,
    /// For it alone.
    Low {
        /// Free, MB.
        free_mb: f64,
        /// Needed, MB.
        need_mb: f64,
        /// To be kept free, MB.
        keep_free_mb: f64,
    },
    /// Not for it.
    TooLittle {
        /// Free, MB.
        free_mb: f64,
        /// Needed, MB.
        need_mb: f64,
    },
}

impl Room {
    pub(super) fn of(free_mb: f64, need: Need, keep_free_mb: f64) -> Self {
        let need_mb = need.mb();
        match free_mb - need_mb {
            left if left >= keep_free_mb => Self::Enough,
            left if left >= 0.0 || need_mb <= 0.0 => Self::Low { free_mb, need_mb, keep_free_mb },
            _ => Self::TooLittle { free_mb, need_mb },
        }
    }
}

impl fmt::Display for Room {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enough => f.write_str("there is room on the disk"),
            Self::Low { free_mb, need_mb, keep_free_mb } if *need_mb <= 0.0 => write!(
                f,
                "{free_mb:.0} MB of the disk are free and {keep_free_mb:.0} are to be kept free (keep_free_mb of [storage]); \
                 remove old recordings, or let [storage] do it (budget_mb, keep_days)"
            ),
            Self::Low { free_mb, need_mb, keep_free_mb } => write!(
                f,
                "{free_mb:.0} MB of the disk are free, the cycle needs about {need_mb:.0} and {keep_free_mb:.0} are to be kept free; \
                 remove old recordings, or let [storage] do it (budget_mb, keep_days)"
            ),
            Self::TooLittle { free_mb, need_mb } => write!(
                f,
                "{free_mb:.0} MB of the disk are free and the cycle needs about {need_mb:.0}: it would be cut; \
                 remove old recordings, or let [storage] do it (budget_mb, keep_days)"
            ),
        }
    }
}

/// Free for this process, MB.
pub(crate) fn free_mb(folder: &Path) -> std::io::Result<f64> {
    let about = statvfs(folder)?;
    Ok(about.blocks_available() as f64 * about.fragment_size() as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::cycles::RunKind;
    use trunnion_core::{HostTime, ProbeSample};
    use trunnion_record::{Item, Recorder, RunHeader};

    /// Three probes at 1 kHz with noise of a few counts, as in `docs/measured/load.md`, for a minute.
    #[test]
    fn a_reading_takes_no_more_room_than_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let probes = (1..=3).map(|k| format!("probe-{k}")).collect();
        let header = RunHeader { probes, ..RunHeader::new("room", RunKind::OnTheFly, "table-bc") };
        let mut recorder = Recorder::create(folder.path(), "room", &header).unwrap();
        let readings = 60_000_i64;
        for k in 0..readings {
            for channel in 0..3_u16 {
                let raw = 30_000 + (k * 7919 + i64::from(channel) * 104_729) % 13;
                let (time_s, value_mm) = (k as f64 * 1e-3, raw as f64 * 3.05e-5);
                let sample = ProbeSample { channel, time_s, raw, value_mm, ..ProbeSample::default() };
                recorder.append(Item::Probe(sample), HostTime(k * 1_000_000));
            }
        }
        let journal = folder.path().join("room.mcap.active").metadata().unwrap().len();
        let finished = recorder.finish(HostTime(readings * 1_000_000)).unwrap().files[0].bytes;
        let each = |bytes: u64| bytes as f64 / (3 * readings) as f64;
        let (journal, finished) = (each(journal), each(finished));
        println!("{journal:.1} and {finished:.1} bytes a reading");
        assert!(journal + finished < BYTES_A_READING, "{journal:.1} + {finished:.1}");
        assert!(
            journal + finished > BYTES_A_READING / 4.0,
            "far too much is asked for: {journal:.1} + {finished:.1}"
        );
    }

    #[test]
    fn room_is_judged_with_its_sizes() {
        let need = Need { readings_per_s: 12_000.0, cycle_s: 600.0 };
        assert!((need.mb() - 293.0).abs() < 1.0, "{}", need.mb());
        assert_eq!(Room::of(1000.0, need, 500.0), Room::Enough);
        let low = Room::of(700.0, need, 500.0).to_string();
        assert!(low.starts_with("700 MB of the disk are free, the cycle needs about 293 and 500"), "{low}");
        let little = Room::of(200.0, need, 500.0).to_string();
        assert!(little.starts_with("200 MB of the disk are free and the cycle needs about 293"), "{little}");
    }
}
