//! How well the samples of a run are known in time, as tables for page and terminal.

use crate::number::{MISSING, plain, signed, value_and_u};
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
            Some((delay_s, u_s)) => duration_and_u(delay_s, u_s),
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
            let of = |seen: &SyncMoveChannel| duration_and_u(seen.delay_s, seen.u_s);
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
fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return MISSING.into();
    }
    let (per_s, unit) = suits(seconds);
    format!("{} {unit}", plain(seconds * per_s))
}

/// The same with its standard uncertainty, as every value with one: `−97.6 µs (u 7.4 µs)`.
pub fn duration_and_u(seconds: f64, u_s: f64) -> String {
    let (per_s, unit) = suits(seconds.abs().max(u_s));
    let (value, u) = value_and_u(Some(seconds * per_s), Some(u_s * per_s), unit);
    format!("{value} (u {u})")
}

fn suits(seconds: f64) -> (f64, &'static str) {
    match seconds.abs() {
        s if s >= 1.0 => (1.0, "s"),
        s if s >= 1e-3 => (1e3, "ms"),
        _ => (1e6, "µs"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_has_the_digits_that_its_uncertainty_bears() {
        assert_eq!(duration_and_u(-97.6e-6, 7.37e-6), "−97.6 µs (u 7.4 µs)");
        assert_eq!(duration_and_u(-137.4e-6, 109.2e-6), "−137 µs (u 109 µs)");
        assert_eq!(duration_and_u(2.0e-6, 1.5e-3), "0.0 ms (u 1.5 ms)");
        assert_eq!((duration(13.04e-3), duration(f64::NAN)), ("13.0 ms".into(), MISSING.into()));
    }
}
