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

/// Attempts at a cell that failed; what it said each time counts unless the computer paused.
const ATTEMPTS: usize = 3;
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

/// How a cell went.
#[derive(Debug, PartialEq)]
enum Outcome {
    Holds,
    /// It failed at first, with these words.
    Sporadic(String),
    /// The computer paused in an attempt, which says nothing of the driver, and it held in none.
    NotJudged,
    Wrong(String),
}

/// The first attempt is made beside other cells, every further one alone: a busy computer may manage that.
async fn judged(subject: &Subject, case: &matrix::Case, name: &str, room: &Semaphore) -> Outcome {
    let mut wrong = Vec::new();
    for attempt in 0..ATTEMPTS {
        let places = if attempt == 0 { 1 } else { AT_ONCE };
        let _places = room.acquire_many(places).await.expect("the semaphore stays open");
        let (begun, pauses) = (std::time::Instant::now(), Pauses::watch());
        let result = bench::run(subject, case).await;
        println!("{name}: {:.1} s", begun.elapsed().as_secs_f64());
        match result {
            Ok(()) if wrong.is_empty() => return Outcome::Holds,
            Ok(()) => return Outcome::Sporadic(wrong.join("\n")),
            Err(what) if pauses.longest() < TOO_LONG => wrong.push(format!("{name}: {what}")),
            Err(_) => {
                println!("{name}: not judged, this computer paused {} ms", pauses.longest().as_millis())
            }
        }
    }
    if wrong.len() < ATTEMPTS { Outcome::NotJudged } else { Outcome::Wrong(wrong.join("\n")) }
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
            cells.spawn(async move { judged(subject, &case, &name, &room).await });
        }
    }
    let results = cells.join_all().await;
    let cells = results.len();
    let judged = cells - results.iter().filter(|result| **result == Outcome::NotJudged).count();
    let (mut failed, mut sporadic) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Outcome::Wrong(what) => failed.push(what),
            Outcome::Sporadic(what) => sporadic.push(what),
            Outcome::Holds | Outcome::NotJudged => {}
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
