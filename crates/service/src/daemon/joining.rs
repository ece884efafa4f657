//! A cycle whose program went on while the service was away: its recordings are joined, and judged as one.
//!
//! A recording goes on with the one before it where its program ran already when it began, and that one was cut off. What else
//! must hold is asked by [`trunnion::join::join`] [docs/decisions/0013-parts-of-one-cycle.md].

use crate::run_record::{self, Known};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use tracing::{info, warn};
use trunnion::cycles::{Cycle, Pace};
use trunnion::join::{UNDER_WAY, join};
use trunnion::results::{RunRecord, RunState};
use trunnion_core::chain;
use trunnion_record::{Item, RunHeader, read_header, visit};

/// How many times its planned duration a program may take: at half the feed override it takes twice as long.
const LONGEST: f64 = 2.0;

/// What must be known of a recording to find the one that it goes on with.
struct Ends {
    header: RunHeader,
    /// Its program ran already when it began.
    under_way: bool,
    /// What recorded it ended before its cycle did.
    cut_off: bool,
}

/// The recording that is to be analysed instead of one that began while its program ran, with its state: joined with what came before
/// it. The same recording where nothing came before; then its state says what is missing.
pub(super) fn whole(recording: PathBuf, record: RunRecord, at: String) -> (PathBuf, RunRecord) {
    let is_one = record.joined_from.is_empty() && record.parts.is_empty();
    let begins =
        Some(&recording).filter(|_| is_one).and_then(|path| ends(path)).filter(|ends| ends.under_way);
    let Some(begins) = begins else { return (recording, record) };
    let missing = |why: &str| {
        let mut record = record.clone();
        let said = format!("the program ran already when the recording began{why}");
        if !record.losses.contains(&said) {
            record.losses.push(said);
        }
        (recording.clone(), record)
    };
    let parts = parts_before(&recording, begins);
    let Some(first) = parts.first() else { return missing("") };
    let first_name = first.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let output = recording.with_file_name(format!("{first_name}-joined.mcap"));
    let all: Vec<PathBuf> = parts.into_iter().chain([recording.clone()]).collect();
    // Of fewer parts, from before the service ended once more.
    if output.exists()
        && let Err(error) = std::fs::remove_file(&output)
    {
        warn!(%error, file = %output.display(), "an older joined recording cannot be removed");
    }
    match join(&all, &output) {
        Ok(joined) => {
            info!(run = joined.run, parts = all.len(), read = joined.read, "parts of one cycle were joined");
            let record = RunRecord {
                why: format!("the service ended while it was recorded, in {} parts", all.len()),
                joined_from: all.iter().filter_map(|path| run_record::file_name(path)).collect(),
                ..run_record::of_recording(&output, RunState::Recorded, at)
            };
            (output, record)
        }
        Err(failure) => {
            let why = chain(&failure);
            warn!(run = %recording.display(), "{why}");
            missing(&format!(", and {first_name} before it is no part of the same cycle: {why}"))
        }
    }
}

/// The recordings that one goes on with, in order of time.
fn parts_before(recording: &Path, begins: Ends) -> Vec<PathBuf> {
    let Some(folder) = recording.parent() else { return Vec::new() };
    let (mut parts, mut next) = (Vec::new(), begins);
    let known = Known::read(folder).runs;
    let joined: HashSet<&PathBuf> =
        known.iter().filter(|(_, record)| !record.joined_from.is_empty()).map(|(path, _)| path).collect();
    while next.under_way
        && let Some((path, ends)) = before(folder, &next.header, &joined)
        && ends.cut_off
        && lies_within_one_run(&ends.header, &next.header)
    {
        parts.insert(0, path);
        next = ends;
    }
    parts
}

/// The recording of a folder that began last before another.
fn before(folder: &Path, header: &RunHeader, joined: &HashSet<&PathBuf>) -> Option<(PathBuf, Ends)> {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let recordings = files.filter(|path| path.extension().is_some_and(|ending| ending == "mcap"));
    let begun = |path: PathBuf| {
        let began_ns = read_header(&path).ok()?.wall_start_ns;
        (began_ns < header.wall_start_ns && !joined.contains(&path)).then_some((began_ns, path))
    };
    let (_, path) = recordings.filter_map(begun).max()?;
    let ends = ends(&path)?;
    Some((path, ends))
}

fn ends(recording: &Path) -> Option<Ends> {
    let (mut under_way, mut ended) = (false, None);
    let (header, _) = visit(recording, &mut |item| {
        if let Item::Event(event) = item {
            under_way |= event.kind == UNDER_WAY;
            if event.kind == "cycle-end" {
                ended = Some(event.text);
            }
        }
        true
    })
    .ok()?;
    // A kill leaves no end, a person who stops the service this one.
    let cut_off = ended.is_none_or(|why| why == format!("{:?}", trunnion_sync::EndReason::Stopped));
    Some(Ends { header, under_way, cut_off })
}

/// Whether a program that began with `first` can still have run when `next` began.
fn lies_within_one_run(first: &RunHeader, next: &RunHeader) -> bool {
    let planned_s = || {
        let machine = first.machine()?.ok()?;
        let cycle = Cycle::parse("recorded cycle", &first.cycle_text).ok()?;
        Some(cycle.visits(&machine, &Pace::default()).ok()?.duration_s)
    };
    let apart_s = (next.wall_start_ns - first.wall_start_ns) as f64 * 1e-9;
    planned_s().is_some_and(|planned_s| apart_s < LONGEST * planned_s)
}
