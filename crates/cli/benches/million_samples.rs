//! A million samples on the fly through the binary: time and memory of `trunnion identify` and `trunnion diagnose`.
//!
//! Two setups, three tilts, three feeds, both ways. Prints wall time and the largest resident memory of each command, and the time of
//! `identify` as a ratio to only reading the points of the file.
//! `cargo bench -p trunnion-cli --bench million_samples [-- FILE]`; the file is made when it does not exist.

#![expect(clippy::unwrap_used, reason = "a bench may panic")]

use nalgebra::Point3;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use trunnion_core::{InstrumentKind, NestSide, Point, Quality, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine, grid};
use trunnion_hil_sim::{HiddenChoice, Instrument, NestOn, SimSetup, Truth};
use trunnion_machine::shipped;

const SAMPLES: u32 = 1_000_000;

fn main() {
    let named = std::env::args().skip(1).find(|argument| argument.ends_with(".mcap"));
    let path = named.map_or_else(|| std::env::temp_dir().join("million-samples.mcap"), PathBuf::from);
    if !path.exists() {
        make(&path);
    }
    let started = Instant::now();
    let mut points = 0_u32;
    trunnion_record::visit_points(&path, &shipped::machine, &mut |_, _, _| points += 1).unwrap();
    let reading = started.elapsed().as_secs_f64();
    println!("reading {points} points: {reading:.2} s");
    for command in ["identify", "diagnose"] {
        let started = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_trunnion")).arg(command).arg(&path).spawn().unwrap();
        let mut most_kb = 0;
        let status = loop {
            most_kb = most_kb.max(resident_kb(child.id()).unwrap_or(0));
            match child.try_wait().unwrap() {
                Some(status) => break status,
                None => std::thread::sleep(std::time::Duration::from_millis(2)),
            }
        };
        let seconds = started.elapsed().as_secs_f64();
        let (ratio, most_mb) = (seconds / reading, most_kb / 1024);
        println!("{command}: {status}, {seconds:.2} s, {ratio:.1} × reading, {most_mb} MB at most");
    }
}

fn make(path: &Path) {
    let machine = shipped::machine("table-bc").unwrap();
    let setups: Vec<SimSetup> = [("low", 60.0), ("high", 160.0)]
        .map(|(name, z)| SimSetup::new(name, NestOn::Table, Point3::new(150.0, 0.0, z), Instrument::RTest))
        .into();
    let hidden = [HiddenChoice { id: "servo-lag:X".into(), sigma: 1.0 }];
    let truth = Truth::draw(&machine, &setups, &hidden, 1200.0, 7).unwrap();
    let virtual_machine = VirtualMachine::new(machine.clone(), truth).unwrap();
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let mut points = Vec::new();
    let mut start_s = 0.0;
    for (setup, placed) in setups.iter().enumerate() {
        for tilt_deg in [-45.0_f64, 0.0, 45.0] {
            for feed_deg in [10.0_f64, 20.0, 40.0] {
                let sweep = grid::Sweep {
                    setup,
                    tilt_rad: tilt_deg.to_radians(),
                    feed_rad_per_s: feed_deg.to_radians(),
                    samples: SAMPLES / 36,
                    start_s,
                };
                for state in grid::c_sweep(&machine, &placed.ball_in_table_mm, &sweep) {
                    let reading_mm = sampler.read_mm(&virtual_machine, &state);
                    points.push(Point {
                        state,
                        reading_mm,
                        spread_mm: [0.0; 3],
                        samples: 1,
                        quality: Quality::Good,
                    });
                }
                start_s += 2.0 * 360.0 / feed_deg + 20.0;
            }
        }
    }
    let setups = setups.iter().map(|placed| {
        Setup::new(placed.name.clone(), InstrumentKind::RTest, NestSide::Table, placed.ball_in_table_mm)
    });
    let run = Run {
        name: "million-samples".into(),
        machine,
        kind: RunKind::OnTheFly,
        setups: setups.collect(),
        channels: Vec::new(),
        points,
    };
    let text = shipped::FILES.iter().find(|(name, _)| *name == "table-bc").unwrap().1;
    let header = trunnion_record::RunHeader::of_run(&run, text, "bench", 0);
    trunnion_record::write_run(path, &header, &run).unwrap();
}

/// Resident memory, kB (Linux).
fn resident_kb(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
