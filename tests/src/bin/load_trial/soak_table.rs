//! `docs/measured/soak.md`.

use crate::floor::{FEEDS_DEG_PER_MIN, Rates};
use crate::readers::Received;
use crate::soak::{Minute, Soak};
use std::fmt::Write;

/// Every tenth minute has a row, and the last.
const ROW_EVERY: usize = 10;
/// Gaps that are shown, of each recording.
const SHOWN_GAPS: usize = 3;

/// The whole document.
pub fn document(soak: &Soak) -> String {
    let Rates { probe_hz, encoder_hz, axes_hz } = soak.rates;
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let mut text = format!(
        "# The service over many cycles\n\n\
         Written by `load-trial soak --program target/release/trunnion --markdown docs/measured/soak.md` of `trunnion-tests`. \
         `trunnion daemon` of an optimised build, in the environment of `systemd/trunnion.service`, reads simulated devices of another process at full rate: three optoNCDT probes at \
         {probe_hz} Hz each, a CANopen encoder at {encoder_hz} Hz, axes at {axes_hz} Hz from an MTConnect agent. One program of {:.0} s \
         follows the other, C forward and back at {} °/min. Each run is recorded and analysed in a process of its own while the next \
         is measured. One client reads the events of the page, another every topic of mosquitto. `[storage]` keeps a budget, so that \
         old recordings go while the trial runs.\n\n\
         It ran for {:.0} min on {cores} cores that other work shared: column \"load\" is that of the whole computer. The longest time that \
         a waiting thread of the trial was left without a processor was {} ms.{}\n\n",
        soak.cycle_s,
        FEEDS_DEG_PER_MIN.map(|feed| feed.to_string()).join(", "),
        soak.ran_s / 60.0,
        soak.longest_pause.as_millis(),
        if soak.release { "" } else { " The devices are of a development build." },
    );
    text += &losses(soak);
    text += &minutes(&soak.minutes);
    text
}

fn losses(soak: &Soak) -> String {
    let judged = || soak.judged.values();
    let recorded: u64 =
        judged().flat_map(|judged| &judged.counts.streams).map(|stream| stream.recorded).sum();
    let sum = |part: fn((u64, u64)) -> u64| judged().map(|judged| part(judged.missing())).sum::<u64>();
    let (missing, silent) = (sum(|(missing, _)| missing), sum(|(_, silent)| silent));
    let gaps: usize = judged().map(|judged| judged.counts.gaps.len()).sum();
    let states: Vec<String> = soak.states.iter().map(|(state, runs)| format!("{runs} {state}")).collect();
    let mut text = format!(
        "## Losses\n\n| | |\n|---|---:|\n| recordings read back and counted | {} |\n| recordings that cannot be read | {} |\n\
         | runs by their state | {} |\n| samples recorded | {recorded} |\n| samples missing | {missing} |\n\
         | of them without a gap that reports them | {silent} |\n| gaps | {gaps} |\n\
         | bytes the devices could not hand over in time | {} |\n{}{}\n",
        soak.judged.len(),
        soak.unreadable.len(),
        states.join(", "),
        soak.bytes_not_taken,
        reader("page", "events", &soak.page),
        reader("broker", "messages", &soak.broker),
    );
    for why in &soak.unreadable {
        // A String takes whatever is written to it.
        writeln!(text, "- {why}").expect("memory");
    }
    for (name, judged) in &soak.judged {
        for silent in judged.silent() {
            writeln!(text, "- `{name}`: {silent}").expect("memory");
        }
        for gap in judged.counts.gaps.iter().take(SHOWN_GAPS) {
            writeln!(text, "- `{name}`: {gap}").expect("memory");
        }
    }
    text
}

fn reader(who: &str, what: &str, received: &Received) -> String {
    format!(
        "| {who}: {what} received, connections made, longest wait for one | {}, {}, {:.1} s |\n",
        received.messages(),
        received.connections(),
        received.longest_wait_ms() as f64 / 1e3,
    )
}

fn minutes(minutes: &[Minute]) -> String {
    let mut text = String::from(
        "\n## What it takes\n\nOf the service's process alone, except the analysis: the most that one of its processes took so far. The folder \
         holds recordings, reports and state files.\n\n\
         | minute | memory, MiB | at most, MiB | descriptors | threads | cores since the row before | analysis at most, MiB | folder, MB | load | health |\n\
         |---:|---:|---:|---:|---:|---:|---:|---:|---:|---|\n",
    );
    let mut before: Option<&Minute> = None;
    for (k, minute) in minutes.iter().enumerate() {
        let is_last = k + 1 == minutes.len();
        if !k.is_multiple_of(ROW_EVERY) && !is_last {
            continue;
        }
        let cores = before.map(|before| {
            (minute.service.cpu_s - before.service.cpu_s) / (minute.service.at_s - before.service.at_s)
        });
        writeln!(
            text,
            "| {} | {:.1} | {:.1} | {} | {} | {} | {:.0} | {:.1} | {:.1} | {} |",
            k + 1,
            minute.service.resident_mib,
            minute.service.peak_mib,
            minute.service.descriptors,
            minute.service.threads,
            cores.map_or_else(String::new, |cores| format!("{cores:.3}")),
            minute.analysis_mib,
            minute.folder_mb,
            minute.load,
            minute.health,
        )
        .expect("memory");
        before = Some(minute);
    }
    text
}
