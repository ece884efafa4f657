//! How well the samples of a run are known in time, as tables for page and terminal.

use crate::number::{MISSING, plain, signed};
use trunnion_results::{Stream, SyncMove, SyncMoveChannel, TimeQuality};

/// Head of the table of streams.
pub const HEAD: [&str; 9] = [
    "stream",
    "samples",
    "per second",
    "clock drift",
    "jitter of arrival",
    "after the line",
    "gaps",
    "lost",
    "later than the axes",
];
/// Its columns of numbers.
pub const NUMERIC: [usize; 7] = [1, 2, 3, 4, 5, 7, 8];

/// What the columns mean.
pub const ABOUT: &str = "Jitter of arrival: the error of a sample stamped when its bytes came. After the line: what the line through \
     the earliest arrivals of the whole run does not follow. Later than the axes: delay with standard uncertainty from the \
     synchronisation moves, taken out of the times.";

/// The streams of a run, a row each.
pub fn rows(quality: &TimeQuality) -> Vec<Vec<String>> {
    quality.streams.iter().map(row).collect()
}

fn row(stream: &Stream) -> Vec<String> {
    let gaps = match stream.gaps {
        0 => "none".into(),
        count => format!("{count}, together {} s", plain(stream.gap_s)),
    };
    vec![
        stream.name.clone(),
        stream.samples.to_string(),
        stream.rate_hz.map_or(MISSING.into(), plain),
        stream.drift_ppm.map_or(MISSING.into(), |ppm| format!("{} ppm", signed(ppm, 2))),
        stream.jitter_before_s.map_or(MISSING.into(), duration),
        stream.jitter_after_s.map_or(MISSING.into(), duration),
        gaps,
        stream.lost.to_string(),
        match stream.delay_s.zip(stream.delay_u_s) {
            Some((delay_s, u_s)) => format!("{} (u {})", duration(delay_s), duration(u_s)),
            None => MISSING.into(),
        },
    ]
}

/// What cannot be said in a row, one sentence each.
pub fn sentences(quality: &TimeQuality) -> Vec<String> {
    let skewed = quality.streams.iter().filter(|stream| stream.skew_s > 0.0).map(|stream| {
        format!(
            "The axes of one reading have stamps of their own, up to {} apart; positions are brought to one instant between them.",
            duration(stream.skew_s)
        )
    });
    let held = quality.streams.iter().filter(|stream| stream.held > 0).map(|stream| {
        format!("{}: {} readings said only that nothing had changed.", stream.name, stream.held)
    });
    let again = quality.streams.iter().filter(|stream| stream.lines > 1).map(|stream| {
        format!("{}: {} lines for its clock (new connections or jumps).", stream.name, stream.lines)
    });
    skewed
        .chain(held)
        .chain(again)
        .chain(quality.sync_moves.iter().map(sync_move))
        .chain(quality.notes.iter().cloned())
        .collect()
}

fn sync_move(sync_move: &SyncMove) -> String {
    let seen = match sync_move.channels.as_slice() {
        [] => "no probe saw it".into(),
        seen => {
            let of =
                |seen: &SyncMoveChannel| format!("{} (u {})", duration(seen.delay_s), duration(seen.u_s));
            format!("readings later by {}", seen.iter().map(of).collect::<Vec<_>>().join(", "))
        }
    };
    format!(
        "Synchronisation move at {} s: strokes of {} over {} mm; {seen}.",
        plain(sync_move.time_s),
        sync_move.axis,
        plain(sync_move.stroke_mm)
    )
}

/// A duration in the unit that suits it: `13 ms`, `420 µs`.
pub fn duration(seconds: f64) -> String {
    match seconds.abs() {
        s if !s.is_finite() => MISSING.into(),
        s if s >= 1.0 => format!("{} s", plain(seconds)),
        s if s >= 1e-3 => format!("{} ms", plain(seconds * 1e3)),
        _ => format!("{} µs", plain(seconds * 1e6)),
    }
}
