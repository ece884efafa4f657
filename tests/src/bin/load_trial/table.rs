//! `docs/measured/load.md`.

use crate::Trial;
use crate::attack;
use crate::floor::{FEEDS_DEG_PER_MIN, Rates};
use std::fmt::Write;
use std::sync::Arc;

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

/// Two cycles side by side: in quiet, and with the page attacked.
pub fn flood(quiet: &Trial, attacked: &Trial) -> String {
    let Rates { probe_hz, encoder_hz, axes_hz } = quiet.rates;
    let mut text = format!(
        "# The page attacked while samples are taken\n\n\
         Written by `cargo run --release -p trunnion-tests --bin load-trial -- --flood --markdown FILE`. Two cycles of {:.0} s with three probes at \
         {probe_hz} Hz, an encoder at {encoder_hz} Hz and axes at {axes_hz} Hz ([load](load.md)), each with somebody at the page who reads its events. \
         During the second a process of its own attacks the page from {} addresses of this computer, each kind of attack alone and in the end all at \
         once, for equal times. {} build.\n\n\
         ## Samples\n\n| | in quiet | attacked |\n|---|---:|---:|\n",
        quiet.judged.seconds,
        attack::ADDRESSES,
        if quiet.release { "Optimised" } else { "Development" },
    );
    let mut row = |words: &str, of: &dyn Fn(&Trial) -> String| {
        text += &format!("| {words} | {} | {} |\n", of(quiet), of(attacked));
    };
    for (k, stream) in quiet.judged.counts.streams.iter().enumerate() {
        row(&format!("{}: expected", stream.name), &|trial| {
            trial.judged.compared(&trial.judged.counts.streams[k]).0.to_string()
        });
        row(&format!("{}: missing", stream.name), &|trial| {
            let (expected, recorded) = trial.judged.compared(&trial.judged.counts.streams[k]);
            expected.saturating_sub(recorded).to_string()
        });
    }
    row("gaps", &|trial| trial.judged.counts.gaps.len().to_string());
    row("samples recorded as lost", &|trial| trial.judged.counts.lost.to_string());
    row("bytes not taken from the devices in time", &|trial| trial.bytes_not_taken.to_string());
    row("points", &|trial| trial.judged.counts.points.to_string());
    row("processor of the service, cores", &|trial| format!("{:.3}", trial.watch.cores()));
    row("memory of the service at most, MiB", &|trial| {
        format!("{:.1}", trial.watch.samples.last().map_or(f64::NAN, |sample| sample.peak_mib))
    });
    row("most messages waiting, drivers to cycle (of 32 768)", &|trial| trial.queues.drivers.to_string());
    row("most messages waiting, cycle to recorder (of 32 768)", &|trial| trial.queues.recorder.to_string());
    let reader = |trial: &Trial| trial.at_page.as_ref().map(|seen| Arc::clone(&seen.reader));
    row("events that the reader of the page got", &|trial| {
        reader(trial).map_or(String::new(), |reader| reader.messages().to_string())
    });
    row("its longest wait for one, ms", &|trial| {
        reader(trial).map_or(String::new(), |reader| reader.longest_wait_ms().to_string())
    });
    row("its connections", &|trial| {
        reader(trial).map_or(String::new(), |reader| reader.connections().to_string())
    });
    text + "\n" + &attempts(attacked)
}

/// What each attack got.
fn attempts(attacked: &Trial) -> String {
    let mut text = String::from("## Attempts\n\n| attack | attempts | got |\n|---|---:|---|\n");
    for (words, got) in attacked.at_page.iter().flat_map(|seen| &seen.attempts) {
        let mut answers: Vec<_> = got.iter().collect();
        answers.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let answers: Vec<String> =
            answers.iter().map(|(answer, count)| format!("{answer}: {count}")).collect();
        text += &format!("| {words} | {} | {} |\n", got.values().sum::<u64>(), answers.join("; "));
    }
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
