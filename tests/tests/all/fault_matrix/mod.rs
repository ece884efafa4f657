//! Every device through everything that can befall it: the state it comes to, the gap in the recording, and the words a
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
use trunnion_tests::pauses::Pauses;

const SUBJECTS: [&Subject; 7] = [
    &optoncdt::SUBJECT,
    &keyence::SUBJECT,
    &ascii::SUBJECT,
    &canopen_slcan::SUBJECT,
    &mtconnect::SUBJECT,
    &linuxcnc::SUBJECT,
    &opcua::SUBJECT,
];
/// Cells run at once; the others wait.
const AT_ONCE: usize = 6;

/// The drivers take a pause of this length for silence of the device.
const TOO_LONG: Duration = Duration::from_millis(200);
/// A cell is judged again where the computer paused, at most so often.
const TRIES: u32 = 4;

/// What is wrong with a cell, on a computer that does not pause meanwhile.
async fn judged(subject: &Subject, case: &matrix::Case, name: &str) -> Result<(), String> {
    for _ in 0..TRIES {
        let (begun, pauses) = (std::time::Instant::now(), Pauses::watch());
        let result = bench::run(subject, case).await;
        println!("{name}: {:.1} s", begun.elapsed().as_secs_f64());
        let Err(what) = result else { return Ok(()) };
        if pauses.longest() < TOO_LONG {
            return Err(format!("{name}: {what}"));
        }
        println!("{name}: too slow to judge, this computer paused {} ms", pauses.longest().as_millis());
    }
    Err(format!("{name}: too slow to judge in {TRIES} tries, this computer paused each time"))
}

#[tokio::test(flavor = "multi_thread")]
async fn each_fault_of_each_device_leads_to_its_state_its_gap_and_its_message() {
    let only = std::env::var("TRUNNION_FAULT_CELLS").unwrap_or_default();
    let room = Arc::new(Semaphore::new(AT_ONCE));
    let mut cells = JoinSet::new();
    for subject in SUBJECTS {
        for trouble in Trouble::ALL {
            let name = format!("{}, {}", subject.driver, trouble.name());
            let Cell::Case(case) = subject.cell(trouble) else { continue };
            if !name.contains(&only) {
                continue;
            }
            let room = Arc::clone(&room);
            cells.spawn(async move {
                let _place = room.acquire().await.expect("the semaphore stays open");
                judged(subject, &case, &name).await
            });
        }
    }
    let results = cells.join_all().await;
    let failed: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
    if only.is_empty() {
        doc::check(&SUBJECTS);
    }
}
