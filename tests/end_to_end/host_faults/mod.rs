//! What happens when the computer fails the service: each fault while a cycle is measured, and what came of it.
//!
//! `trunnion daemon` reads simulated devices on real ports. Each row is a fault, the line of the log that reports it, what the
//! recordings say, and the state of the run in the end; the table of docs/measured/host-faults.md is what this test checks.

mod bench;
mod faults;
mod losses;

use super::section;
use bench::{Bench, Wrong};
use faults::FAULTS;
use losses::Hole;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::Semaphore;
use trunnion::results::RunState;
use trunnion_hil_sim::attempts::{Failure, Outcome, judged};
use trunnion_hil_sim::pauses::Pauses;

/// Services at once: each simulates three probes at 1 kHz, and one more analyses.
const AT_ONCE: u32 = 2;
/// Rows in which a pause of the computer may be to blame: more of them say more of the service than of the computer. A judgement, tuned on no
/// data.
const EXCUSED: usize = 1;
/// How much shorter than the hole a pause is measured: the sleep of the watch, and a step of the probes, which are simulated every
/// millisecond, at either end.
const WATCH: Duration = Duration::from_millis(5);

/// A fault, and what it must lead to.
struct Fault {
    /// Its name.
    name: &'static str,
    /// How the test brings it about.
    how: &'static str,
    /// Lines of the log that report it and its end.
    says: &'static [&'static str],
    /// Words of the reason of a gap in the recordings; none where the service itself lost nothing.
    gap: Option<&'static str>,
    /// States of the run that are right in the end.
    ends: &'static [RunState],
    /// What a person does, or the service by itself.
    recovery: &'static str,
    /// Brings it about while a cycle is measured, and mends what a person would mend.
    run: fn(&mut Bench),
}

impl Fault {
    /// A row of the table.
    fn row(&self) -> String {
        let says: Vec<String> = self.says.iter().map(|line| format!("`{line}`")).collect();
        let says = if says.is_empty() { "–".into() } else { says.join(", then ") };
        let states: Vec<String> = self.ends.iter().map(|state| format!("`{}`", state.as_str())).collect();
        let gap = self.gap.map_or("none of the recorder".into(), |words| format!("`{words}`"));
        format!(
            "| {} | {} | {} | {gap} | {} | {} |\n",
            self.name,
            self.how,
            says,
            states.join(" or "),
            self.recovery
        )
    }
}

/// One attempt at a row. Only a hole in which the simulated devices of this process stood still is the doing of the computer.
async fn attempt(fault: &'static Fault) -> Result<(), Failure> {
    let (pauses, now, wall) = (Pauses::watch(), Instant::now(), SystemTime::now());
    let moment = |wall_ns: i64| {
        let at = UNIX_EPOCH + Duration::from_nanos(wall_ns.max(0).cast_unsigned());
        now + at.duration_since(wall).unwrap_or_default()
    };
    bench::judge(fault).await.map_err(|wrong| match wrong {
        Wrong::Silent(holes, what) => {
            let is_explained = |hole: &Hole| {
                let from = moment(hole.from_ns);
                pauses.longest_between(from, from + hole.length) + WATCH >= hole.length
            };
            match holes.iter().all(is_explained) {
                true => Failure::Paused(what),
                false => Failure::Wrong(what),
            }
        }
        Wrong::Other(what) => Failure::Wrong(what),
    })
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_fault_of_the_computer_is_reported_costs_no_sample_in_silence_and_ends_in_a_state() {
    let only = std::env::var("TRUNNION_HOST_FAULTS").unwrap_or_default();
    let room = Arc::new(Semaphore::new(AT_ONCE as usize));
    let mut running = tokio::task::JoinSet::new();
    for fault in FAULTS.iter().filter(|fault| fault.name.contains(&only)) {
        let room = Arc::clone(&room);
        running.spawn(async move { judged(fault.name, &room, AT_ONCE, || attempt(fault)).await });
    }
    let (mut wrong, mut excused) = (Vec::new(), Vec::new());
    for outcome in running.join_all().await {
        match outcome {
            Outcome::Holds => {}
            Outcome::HoldsAtLast(what) | Outcome::NotJudged(what) => excused.push(what),
            Outcome::Sporadic(what) | Outcome::Wrong(what) => wrong.push(what),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(excused.len() <= EXCUSED, "this computer paused in too many rows:\n{}", excused.join("\n\n"));
    if only.is_empty() {
        let head =
            "| fault | how | the log says | gap | state of the run | recovery |\n|---|---|---|---|---|---|\n";
        let rows: String = FAULTS.iter().map(Fault::row).collect();
        section::write_or_compare("docs/measured/host-faults.md", "host faults", &(head.to_owned() + &rows));
    }
}
