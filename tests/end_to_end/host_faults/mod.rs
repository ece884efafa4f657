//! What happens when the computer fails the service: each fault while a cycle is measured, and what came of it.
//!
//! `trunnion daemon` reads simulated devices on real ports. Each row is a fault, the line of the log that reports it, what the
//! recordings say, and the state of the run in the end; the table of docs/measured/host-faults.md is what this test checks.

mod bench;
mod faults;
mod losses;

use super::section;
use bench::Bench;
use faults::FAULTS;
use losses::HOLE_STEPS;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use trunnion::results::RunState;
use trunnion_hil_sim::pauses::Pauses;

/// Services at once: each simulates three probes at 1 kHz, and one more analyses.
const AT_ONCE: usize = 2;
/// Attempts at a row that failed while the computer paused.
const ATTEMPTS: usize = 3;

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

/// A row that did not hold.
struct Failure {
    said: String,
    /// The computer paused for as long as a hole between samples: the simulated devices of this process stood still.
    paused: bool,
}

async fn attempt(fault: &'static Fault) -> Result<(), Failure> {
    let pauses = Pauses::watch();
    let judged = tokio::spawn(bench::judge(fault)).await;
    let said = match judged {
        Ok(Ok(())) => return Ok(()),
        Ok(Err(said)) => said,
        Err(panic) => format!("{}: {panic}", fault.name),
    };
    // Simulated probes send every millisecond.
    let paused = pauses.longest() > Duration::from_secs_f64(HOLE_STEPS * 1e-3);
    Err(Failure { said, paused })
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_fault_of_the_computer_is_reported_costs_no_sample_in_silence_and_ends_in_a_state() {
    let only = std::env::var("TRUNNION_HOST_FAULTS").unwrap_or_default();
    let room = Arc::new(Semaphore::new(AT_ONCE));
    let mut running = tokio::task::JoinSet::new();
    for fault in FAULTS.iter().filter(|fault| fault.name.contains(&only)) {
        let room = Arc::clone(&room);
        running.spawn(async move {
            let _place = room.acquire_owned().await.unwrap();
            (fault, attempt(fault).await)
        });
    }
    let (mut wrong, mut again) = (Vec::new(), Vec::new());
    while let Some(judged) = running.join_next().await {
        match judged {
            Ok((_, Ok(()))) => {}
            Ok((_, Err(Failure { said, paused: false }))) => wrong.push(said),
            Ok((fault, Err(Failure { said, paused: true }))) => again.push((fault, said)),
            Err(panic) => wrong.push(panic.to_string()),
        }
    }
    // Alone: what failed beside other work while the computer paused says nothing of the service.
    for (fault, mut said) in again {
        for _ in 1..ATTEMPTS {
            println!("{}: not judged, the computer paused: {said}", fault.name);
            match attempt(fault).await {
                Ok(()) => {
                    said.clear();
                    break;
                }
                Err(failure) => {
                    said = failure.said;
                    if !failure.paused {
                        break;
                    }
                }
            }
        }
        wrong.extend(Some(said).filter(|said| !said.is_empty()));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    if only.is_empty() {
        let head =
            "| fault | how | the log says | gap | state of the run | recovery |\n|---|---|---|---|---|---|\n";
        let rows: String = FAULTS.iter().map(Fault::row).collect();
        section::write_or_compare("docs/measured/host-faults.md", "host faults", &(head.to_owned() + &rows));
    }
}
