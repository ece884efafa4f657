//! The next day is forecast from whole runs, and a forecast that fails says why.

use std::path::{Path, PathBuf};
use trunnion::history::{Keeper, next_day};
use trunnion_core::{Point, State};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-nothing-hidden/points.csv");

const DAY_NS: i64 = 86_400_000_000_000;

/// A run of the committed points in as many recordings as there are `parts`; days differ a little.
pub fn run(folder: &Path, day: usize, parts: usize) -> Vec<PathBuf> {
    let run = trunnion::read(Path::new(DATA), None).unwrap().run;
    let name = format!("day-{day}");
    let mut recordings = Vec::new();
    for (part, points) in run.points.chunks(run.points.len().div_ceil(parts)).enumerate() {
        let of_day = |k: usize, point: &Point| {
            let off_mm = 1e-4 * ((day * 5 + k) % 7) as f64 * day as f64;
            let time_s = Some((part * 1000 + k) as f64);
            let state = State { time_s, ..point.state.clone() };
            Point { state, reading_mm: point.reading_mm.map(|mm| mm + off_mm), ..point.clone() }
        };
        let points: Vec<Point> = points.iter().enumerate().map(|(k, point)| of_day(k, point)).collect();
        let header = trunnion_record::RunHeader {
            setups: run.setups.clone(),
            cycle_text: String::new(),
            wall_start_ns: day as i64 * DAY_NS,
            ..crate::header(&name, include_str!("../../../../config/cycles/demo-static.toml"))
        };
        let path = folder.join(format!("{name}-of-{parts}-{part}.mcap"));
        let part = trunnion_cycles::Run { points, ..run.clone() };
        trunnion_record::write_run(&path, &header, &part).unwrap();
        recordings.push(path);
    }
    recordings
}

#[test]
fn every_part_of_a_run_counts() {
    let folder = tempfile::tempdir().unwrap();
    let mut days: Vec<Vec<PathBuf>> = (1..=4).map(|day| run(folder.path(), day, 1)).collect();
    days.push(run(folder.path(), 5, 2));
    let forecast = next_day(&days, None, &mut Keeper::default());
    assert_eq!(forecast.runs, ["day-1", "day-2", "day-3", "day-4", "day-5"], "{forecast:?}");
    let points = trunnion::open(DATA).unwrap().runs()[0].points.len();
    assert_eq!(forecast.checked.as_ref().map(|run| run.points), Some(points), "{forecast:?}");
}

#[test]
fn a_forecast_that_fails_is_none_with_the_reason() {
    let gone: Vec<Vec<PathBuf>> = (1..=5).map(|day| vec![format!("gone/day-{day}.mcap").into()]).collect();
    let forecast = next_day(&gone, None, &mut Keeper::default());
    assert!(
        forecast.why_not.contains("it failed: ") && forecast.why_not.contains("gone/day-5.mcap"),
        "{forecast:?}"
    );
    assert_eq!(forecast.words.len(), 1);
    assert!(forecast.words[0].starts_with("No forecast of the next day: it failed: "), "{forecast:?}");
}
