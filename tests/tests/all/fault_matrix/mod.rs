//! Every device through every fault that it can have: the state it comes to, the gap in the recording, and the words a
//! technician reads. The devices are virtual, their ports and all that reads them are real. docs/measured/faults.md is written
//! from these cells.

mod ascii;
mod bench;
mod canopen_slcan;
mod common;
mod doc;
mod keyence;
mod linuxcnc;
mod matrix;
mod mtconnect;
mod opcua;
mod optoncdt;
mod seen;
mod tape;

use matrix::{Cell, Subject, Trouble};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use trunnion_acquire::drivers::DRIVERS;
use trunnion_tests::attempts::{Failure, Outcome, judged};
use trunnion_tests::pauses::Pauses;

const SUBJECTS: &[&Subject] = &[
    &optoncdt::SUBJECT,
    &keyence::SUBJECT,
    &ascii::SUBJECT,
    &canopen_slcan::SUBJECT,
    &mtconnect::SUBJECT,
    &linuxcnc::SUBJECT,
    &opcua::SUBJECT,
];
/// Cells run at once; the others wait.
const AT_ONCE: u32 = 6;

/// The drivers take a pause of this length for silence of the device.
const TOO_LONG: Duration = Duration::from_millis(200);
/// Of the cells, at least this share must have been judged.
const LEAST_JUDGED: f64 = 0.8;

/// Cells that may fail once on a computer that did not pause and then hold: other work can also delay without one long pause.
const SPORADIC: usize = 1;

/// Drivers without a subject: SocketCAN needs a kernel with CAN, so its faults are a peer test (tests/tests/peers/socketcan.rs).
const ELSEWHERE: [&str; 1] = ["canopen-socketcan"];

#[test]
fn every_driver_has_a_subject() {
    for driver in DRIVERS {
        assert!(
            ELSEWHERE.contains(&driver.name) || SUBJECTS.iter().any(|subject| subject.driver == driver.name),
            "tests/tests/all/fault_matrix needs a file with a SUBJECT of {} and its line in SUBJECTS",
            driver.name
        );
    }
}

/// One attempt at a cell.
async fn attempt(subject: &Subject, case: &matrix::Case, name: &str) -> Result<(), Failure> {
    let (begun, pauses) = (std::time::Instant::now(), Pauses::watch());
    let result = bench::run(subject, case).await;
    println!("{name}: {:.1} s", begun.elapsed().as_secs_f64());
    result.map_err(|what| match pauses.longest() {
        paused if paused >= TOO_LONG => Failure::Paused(format!("{} ms: {what}", paused.as_millis())),
        _ => Failure::Doubtful(what),
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn each_fault_of_each_device_leads_to_its_state_its_gap_and_its_message() {
    let only = std::env::var("TRUNNION_FAULT_CELLS").unwrap_or_default();
    let room = Arc::new(Semaphore::new(AT_ONCE as usize));
    let mut cells = JoinSet::new();
    for subject in SUBJECTS {
        for trouble in Trouble::ALL {
            let name = format!("{}, {}", subject.driver, trouble.name());
            let Cell::Case(case) = subject.cell(trouble) else { continue };
            if !name.contains(&only) {
                continue;
            }
            let room = Arc::clone(&room);
            let judging =
                async move { judged(&name, &room, AT_ONCE, || attempt(subject, &case, &name)).await };
            cells.spawn(judging);
        }
    }
    let results = cells.join_all().await;
    let cells = results.len();
    let judged = cells - results.iter().filter(|result| matches!(result, Outcome::NotJudged(_))).count();
    let (mut failed, mut sporadic) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Outcome::Wrong(what) => failed.push(what),
            Outcome::Sporadic(what) => sporadic.push(what),
            Outcome::Holds | Outcome::HoldsAtLast(_) | Outcome::NotJudged(_) => {}
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
    println!("{} of {cells} cells failed once and held then\n{}", sporadic.len(), sporadic.join("\n"));
    assert!(sporadic.len() <= SPORADIC, "{}", sporadic.join("\n\n"));
    assert!(
        judged as f64 >= LEAST_JUDGED * cells as f64,
        "this computer paused: {judged} of {cells} cells judged"
    );
    if only.is_empty() {
        doc::check(SUBJECTS);
    }
}
