//! Why the demo lost data: the simulated devices lose nothing by themselves, so a pause of the computer is the usual reason. It is
//! measured, not assumed.

use std::path::Path;
use std::time::Duration;
use trunnion_acquire::drivers::DRIVERS;
use trunnion_core::number::counted;

/// One sentence; empty when nothing was lost.
pub fn why(losses: &[String], longest_pause: Duration) -> String {
    listed(losses, longest_pause, "listed in the report")
}

/// A failure, with its reason where that is the computer: nothing started in time, or too little was read to be analysed.
pub fn failed(
    losses: &[String],
    longest_pause: Duration,
    recording: &Path,
    error: anyhow::Error,
) -> anyhow::Error {
    let list = format!("`trunnion check {}` lists them", recording.display());
    match (losses, is_too_slow(longest_pause)) {
        ([], false) => error,
        ([], true) => anyhow::anyhow!("This computer was {}. {error:#}", too_slow("", longest_pause)),
        _ => anyhow::anyhow!("{} Too little was read: {error:#}", listed(losses, longest_pause, &list)),
    }
}

fn listed(losses: &[String], longest_pause: Duration, list: &str) -> String {
    let Some(first) = losses.first() else { return String::new() };
    let gaps = counted(losses.len() as u64, "gap");
    if is_too_slow(longest_pause) {
        let lost = format!(" ({gaps}, {list})");
        return format!("Data loss: this computer was {}.", too_slow(&lost, longest_pause));
    }
    let pause_ms = longest_pause.as_millis();
    format!(
        "Data loss: {gaps}, {list}, the first: {first}. The longest pause of this computer was {pause_ms} ms, too short to be the reason."
    )
}

fn too_slow(lost: &str, longest_pause: Duration) -> String {
    let pause_ms = longest_pause.as_millis();
    format!(
        "too slow to simulate the machine and to measure it at the same time{lost}: it paused for {pause_ms} ms. End other programs and run the \
         demo again"
    )
}

fn is_too_slow(longest_pause: Duration) -> bool {
    longest_pause.as_millis() as f64 >= silence_ms()
}

/// After so long a probe of the demo counts as silent: a pause of that length alone makes a gap.
fn silence_ms() -> f64 {
    let drivers = DRIVERS.iter().filter(|driver| driver.name == "optoncdt");
    drivers.map(|driver| driver.default_silence_ms).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_computer_is_blamed_for_a_pause_that_was_measured_and_for_nothing_else() {
        assert_eq!(why(&[], Duration::from_secs(9)), "");
        let lost = ["probe-1: nothing from 1.00 s to 1.40 s (silent)".to_string()];
        let said = why(&lost, Duration::from_millis(400));
        assert!(
            said.contains("too slow") && said.contains("paused for 400 ms") && said.contains("1 gap,"),
            "{said}"
        );
        let too_few = || anyhow::anyhow!("6 readings are too few");
        let said = failed(&lost, Duration::from_millis(400), Path::new("a.mcap"), too_few()).to_string();
        assert!(
            said.contains("too slow") && said.contains("check a.mcap") && said.contains("6 readings"),
            "{said}"
        );
        let said = failed(&[], Duration::from_secs(9), Path::new("a.mcap"), too_few()).to_string();
        assert!(said.contains("too slow") && said.contains("6 readings") && !said.contains("gap"), "{said}");
        assert_eq!(
            failed(&[], Duration::ZERO, Path::new("a.mcap"), too_few()).to_string(),
            "6 readings are too few"
        );
        let said = why(&lost, Duration::from_millis(30));
        assert!(
            !said.contains("too slow") && said.contains("probe-1") && said.contains("30 ms, too short"),
            "{said}"
        );
    }
}
