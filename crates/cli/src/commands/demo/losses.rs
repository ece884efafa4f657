//! Why the demo lost data: the simulated devices lose nothing by themselves, so a pause of the computer is the usual reason. It is
//! measured, not assumed.

use std::time::Duration;
use trunnion_acquire::drivers::DRIVERS;
use trunnion_core::number::counted;

/// One sentence; empty when nothing was lost.
pub fn why(losses: &[String], longest_pause: Duration) -> String {
    let Some(first) = losses.first() else { return String::new() };
    let gaps = counted(losses.len() as u64, "gap");
    let pause_ms = longest_pause.as_millis();
    if pause_ms as f64 >= silence_ms() {
        return format!(
            "Data loss: this computer was too slow to simulate the machine and to measure it at the same time ({gaps}, listed in the \
             report): it paused for {pause_ms} ms. End other programs and run the demo again."
        );
    }
    format!(
        "Data loss: {gaps}, listed in the report, the first: {first}. The longest pause of this computer was {pause_ms} ms, too short to be \
         the reason."
    )
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
        let said = why(&lost, Duration::from_millis(30));
        assert!(
            !said.contains("too slow") && said.contains("probe-1") && said.contains("30 ms, too short"),
            "{said}"
        );
    }
}
