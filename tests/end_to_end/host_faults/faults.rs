//! The faults.

use super::Fault;
use super::bench::Bench;
use crate::program;
use crate::shop::until;
use std::io::Write;
use trunnion::results::RunRecord;
use trunnion::results::RunState::{self, Done, Failed, NotJudged};
use trunnion_hil_sim::devices;

/// In the order of the table.
pub const FAULTS: &[Fault] = &[
    Fault {
        name: "killed while it records",
        how: "SIGKILL in mid-cycle, started again",
        says: &["recovered a recording that was not finished"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself at the next start",
        run: |bench| {
            bench.start();
            bench.recording();
            bench.restart();
        },
    },
    Fault {
        name: "killed while it analyses",
        how: "SIGKILL, started again",
        says: &["analysed now: it has no report"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself at the next start",
        run: |bench| {
            bench.start();
            bench.state(|record| record.state == RunState::Analysing);
            bench.restart();
        },
    },
    Fault {
        name: "killed before it analyses",
        how: "SIGKILL while it analyses, the state on disk set back to `recovered`, started again; the same with `recorded`",
        says: &["analysed now: it has no report"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself at the next start",
        run: |bench| {
            bench.start();
            for state in [RunState::Recovered, RunState::Recorded] {
                bench.state(|record| record.state == RunState::Analysing);
                bench.kill();
                bench.set_back(state);
                bench.start();
            }
        },
    },
    Fault {
        name: "killed while it joins",
        how: "SIGKILL in mid-cycle, started again while the program runs; SIGKILL while the whole cycle is analysed, started again",
        says: &["parts of one cycle were joined", "analysed now: it has no report"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself at the next start: the whole is judged, its parts stay `joined`",
        run: |bench| {
            let is_whole = |record: &RunRecord| record.joined_from.len() == 2;
            bench.start();
            bench.recording();
            bench.restart();
            bench.state(|record| is_whole(record) && record.state == RunState::Analysing);
            bench.restart();
            bench.state(|record| is_whole(record) && record.state.has_report());
            bench.state(|record| record.state == RunState::Joined);
        },
    },
    Fault {
        name: "suspended",
        how: "SIGSTOP for 2 s in mid-cycle",
        says: &[],
        gap: Some("values lost on the line (counter jumped)"),
        ends: &[Done, NotJudged],
        recovery: "by itself",
        run: |bench| {
            bench.start();
            bench.recording();
            stopped(bench, 2_000);
        },
    },
    Fault {
        name: "processor starved",
        how: "40 times 90 ms without a processor, 10 ms with one",
        says: &[],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself",
        run: |bench| {
            bench.start();
            bench.recording();
            for _ in 0..40 {
                stopped(bench, 90);
                // The fault itself: so long with a processor.
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
        },
    },
    Fault {
        name: "disk full",
        how: "another program takes the rest of the disk in mid-cycle, and gives it back",
        says: &["recording interrupted, kept in memory", "recording goes on in a new file"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "by itself when there is room; 8 MB wait in memory, what they cannot hold is a gap with its number of samples",
        run: |bench| {
            bench.start_on_a_small_disk();
            bench.recording();
            let other = bench.runs().join("of another program");
            let mut file = std::fs::File::create(&other).unwrap();
            until("a full disk", || {
                // As much as fits.
                file.write_all(&[1; 1 << 20]).ok();
                bench.has_said("recording interrupted").then_some(())
            });
            std::fs::remove_file(&other).unwrap();
        },
    },
    Fault {
        name: "read-only",
        how: "killed in mid-cycle; the disk is mounted read-only at the next start, and writable again later; then started again",
        says: &["cannot write into the folder", "of the recordings can be written again"],
        gap: None,
        ends: &[Done, NotJudged],
        recovery: "`failing` and not ready, with the reason, until it can be written, which is tried every second; what the kill left is recovered at the next start",
        run: |bench| {
            bench.start();
            bench.recording();
            bench.kill();
            bench.start_on_a_read_only_disk();
            bench.publishes("recordings: cannot write into the folder");
            bench.publishes("\"state\":\"failing\"");
            bench.make_writable();
            bench.says("can be written again");
            bench.publishes("\"state\":\"good\"");
            bench.restart();
        },
    },
    Fault {
        name: "folder removed",
        how: "`rm -r` of the folder of the recordings in mid-cycle",
        says: &["is not there any more", "recording goes on in a new file"],
        gap: Some("is not there any more"),
        ends: &[Done, NotJudged],
        recovery: "by itself: the folder is made again; what was in it is a gap with its number of samples",
        run: |bench| {
            bench.start();
            bench.recording();
            std::fs::remove_dir_all(bench.runs()).unwrap();
        },
    },
    Fault {
        name: "clock set",
        how: "the wall clock is set forward by ten years in mid-cycle, `keep_days = 365` of `[storage]`, a recording of the day before",
        says: &["the clock of the computer was set forward by 3650.00 days"],
        gap: None,
        ends: &[Done],
        recovery: "none is needed: dates of files and reports follow the clock, times of samples and ages of recordings do not, nothing is removed",
        run: |bench| {
            bench.configure("[storage]\nkeep_days = 365\n");
            let earlier = bench.earlier_run();
            bench.start_with_faults();
            bench.recording();
            bench.fault("clock", Some("315360000"));
            bench.says("the clock of the computer was set forward");
            assert!(earlier.exists(), "the folder was tidied since");
        },
    },
    Fault {
        name: "disk hangs",
        how: "no fdatasync of the recorder returns for 35 s in mid-cycle; a socket in place of systemd",
        says: &[
            "the recorder hangs: it has done nothing for 30 s; systemd starts the service again in 30 s",
            "the recorder goes on",
        ],
        gap: Some("the queue to the recorder was full"),
        ends: &[Done, NotJudged],
        recovery: "systemd hears nothing more and starts the service again 30 s later; a disk that comes back before is gone on with",
        run: |bench| {
            bench.start_with_faults();
            until("the watchdog", || bench.heard().contains("WATCHDOG=1").then_some(()));
            bench.recording();
            bench.fault("hang", Some(""));
            bench.says("the recorder hangs");
            bench.heard();
            // That nothing comes cannot be awaited: five looks of the watchdog.
            std::thread::sleep(std::time::Duration::from_secs(5));
            assert!(!bench.heard().contains("WATCHDOG"), "a recorder that hangs withholds it");
            bench.fault("hang", None);
            until("the watchdog again", || bench.heard().contains("WATCHDOG=1").then_some(()));
        },
    },
    Fault {
        name: "broker gone",
        how: "the broker ends in mid-cycle and is there again",
        says: &["lost the MQTT broker"],
        gap: None,
        ends: &[Done],
        recovery: "by itself; the broker gets the values as they are then",
        run: |bench| {
            bench.start();
            until("the broker", || (bench.broker.counts().0 > 0).then_some(()));
            bench.recording();
            bench.broker.go();
            bench.says("lost the MQTT broker");
            let before = bench.broker.counts().0;
            bench.broker.come_back();
            until("the broker again", || (bench.broker.counts().0 > before).then_some(()));
        },
    },
    Fault {
        name: "controller gone",
        how: "the network to the controller is down for 2 s in mid-cycle",
        says: &["disconnected"],
        gap: Some("cnc: "),
        ends: &[Done, NotJudged],
        recovery: "by itself; poses that were not seen are missing",
        run: |bench| {
            bench.start();
            bench.recording();
            bench.controller(devices::Fault::Unplug { duration_s: 2.0 });
        },
    },
    Fault {
        name: "analysis hangs",
        how: "`time_s = 10` of `[analysis]`, the process stopped",
        says: &["it took more than 10 s (time_s of [analysis]) and was ended"],
        gap: None,
        ends: &[Failed],
        recovery: "it is tried again at the next start, `tries` times in all",
        run: |bench| {
            bench.configure("[analysis]\ntime_s = 10\n");
            bench.start();
            let id = until("an analysis", || bench.service.as_ref()?.analyses().first().copied());
            std::process::Command::new("kill").args(["-STOP", &id.to_string()]).status().unwrap();
        },
    },
    Fault {
        name: "analysis without memory",
        how: "`memory_mb = 64` of `[analysis]`, a recording of 336 poses",
        says: &["it needed more than 64 MB (memory_mb of [analysis])"],
        gap: None,
        ends: &[Failed],
        recovery: "the recording is kept; it is tried again at the next start, `tries` times in all, so after `memory_mb` was raised",
        run: |bench| {
            bench.configure("[analysis]\nmemory_mb = 64\n");
            let recording = program::import("points-gravity", &bench.runs());
            bench.start();
            let failed = bench.state(|record| record.state == Failed);
            assert_eq!(failed.why, "it needed more than 64 MB (memory_mb of [analysis])");
            assert!(std::path::Path::new(&recording).exists(), "it is kept");
        },
    },
];

/// Without a processor for so long.
fn stopped(bench: &Bench, for_ms: u64) {
    let service = bench.service.as_ref().unwrap();
    service.signal("STOP");
    // The fault itself.
    std::thread::sleep(std::time::Duration::from_millis(for_ms));
    service.signal("CONT");
}
