//! `docs/measured/load.md`.

use crate::Trial;
use crate::floor::{FEEDS_DEG_PER_MIN, Rates};
use std::fmt::Write;

/// The whole document.
pub fn document(trial: &Trial) -> String {
    let Rates { probe_hz, encoder_hz, axes_hz } = trial.rates;
    let mut text = String::from("# The service under load\n\n");
    text += &format!(
        "Written by `cargo run --release -p trunnion-tests --bin load-trial -- --markdown docs/measured/load.md`. Simulated devices \
         on pseudo-terminals and a network port of one process; the service (`serve`, as `trunnion daemon` runs it) in \
         another: three optoNCDT probes at {probe_hz} Hz each, a CANopen encoder read by SYNC at {encoder_hz} Hz behind a \
         serial adapter, five axes at {axes_hz} Hz from an MTConnect agent, while C turns forward and back at {} °/min. {} \
         build, a cycle of {:.0} s.\n\n",
        FEEDS_DEG_PER_MIN.map(|feed| feed.to_string()).join(", "),
        if trial.release { "Optimised" } else { "Development" },
        trial.judged.seconds,
    );
    text += &streams(trial);
    text += &cost(trial);
    text
}

fn streams(trial: &Trial) -> String {
    let mut text = String::from(
        "## Samples\n\nExpected: from the first to the last sample by the device's own clock. For encoder and axes, what \
         the device sent against what is in the recording, a second at both ends left out.\n\n\
         | stream | expected | recorded | missing | rate, Hz | longest step, ms |\n|---|---:|---:|---:|---:|---:|\n",
    );
    for stream in &trial.judged.counts.streams {
        let (expected, recorded) = trial.judged.compared(stream);
        let rate_hz = stream.inside as f64 / (trial.judged.seconds - 2.0 * crate::floor::EDGE_S);
        text += &format!(
            "| {} | {expected} | {recorded} | {} | {rate_hz:.1} | {:.2} |\n",
            stream.name,
            expected.saturating_sub(recorded),
            stream.longest_step_ms,
        );
    }
    text += &format!(
        "\n{} points were made of them; {} gaps, {} of them without a number; {} samples recorded as lost; {} bytes not taken from the devices in time. \
         The finished recording has {:.1} MB.\n",
        trial.judged.counts.points,
        trial.judged.counts.gaps.len(),
        trial.judged.counts.uncounted,
        trial.judged.counts.lost,
        trial.bytes_not_taken,
        trial.judged.counts.file_mb,
    );
    for gap in &trial.judged.counts.gaps {
        text += &format!("- {gap}\n");
    }
    text
}

fn cost(trial: &Trial) -> String {
    let watch = &trial.watch;
    let minute_s = (trial.judged.seconds / 4.0).min(60.0);
    let end_s = watch.samples.last().map_or(0.0, |sample| sample.at_s);
    let peak = watch.samples.last().map_or(f64::NAN, |sample| sample.peak_mib);
    let mut text = format!(
        "\n## Cost\n\nProcessor time (user and system) and memory of the service's process alone, while the cycle ran.\n\n\
         | | |\n|---|---:|\n| processor, cores | {:.3} |\n| memory in the first {minute_s:.0} s, MiB | {:.1} |\n\
         | memory in the last {minute_s:.0} s, MiB | {:.1} |\n| memory at most, MiB | {peak:.1} |\n\
         | most messages waiting, drivers to cycle (of 32 768) | {} |\n\
         | most messages waiting, cycle to recorder (of 32 768) | {} |\n\n| thread | cores |\n|---|---:|\n",
        watch.cores(),
        watch.resident_mib(0.0, minute_s),
        watch.resident_mib(end_s - minute_s, end_s),
        trial.queues.drivers,
        trial.queues.recorder,
    );
    for (name, cores) in watch.cores_by_thread().into_iter().take(4) {
        // A String takes whatever is written to it.
        writeln!(text, "| {name} | {cores:.3} |").expect("memory");
    }
    text
}
