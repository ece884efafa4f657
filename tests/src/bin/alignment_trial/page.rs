//! docs/measured/alignment.md.

use crate::floor::Floor;
use crate::promise;
use crate::promise::{Promise, behind};
use std::fmt::Write;
use trunnion_tests::alignment::{HEAD, OMEGA, RADIUS_MM, SOCKETCAN, StreamErrors, row};
use trunnion_tests::section::Section;

/// The page; the section of the emulated computer is that of the page `before`.
pub fn page(floor: &Floor, streams: &[StreamErrors], seconds: f64, before: &str) -> String {
    let mut page = introduction(seconds) + &promises() + REMARKS + HEAD;
    for (stream, device) in streams.iter().zip(&floor.devices) {
        page += &row(device.name, device.transport, stream);
    }
    let emulated = Section::of(before, SOCKETCAN).map_or("not measured yet\n", |section| section.inside);
    let (begin, end) = Section::marks(SOCKETCAN);
    write!(page, "{EMULATED}{begin}{emulated}{end}").expect("a string takes all text");
    page
}

fn introduction(seconds: f64) -> String {
    let um_per_us = OMEGA * RADIUS_MM * 1e-3;
    format!(
        "# Alignment in time\n\n\
         How far the time of a sample is from the truth, measured on the simulated devices through real ports and the real drivers:\n\
         `cargo run --release -p trunnion-tests --bin alignment-trial -- --output docs/measured/alignment.md` ({seconds:.0} s, all devices at once;\n\
         the figures are of the computer it ran on, written by that command). C turns at 3600°/min; at {RADIUS_MM} mm from it 1 µs is\n\
         {um_per_us:.3} µm of path. That is the cost where something is computed from axis positions and readings of different\n\
         instants. A reading of an R-test whose linear axes follow the ball costs only |de/dθ|·ω·δt, some hundred times less.\n\n\
         Stamped on arrival: when the bytes were read. Line: the lower hull of arrivals against the device's clock (`sync::clock`),\n\
         as it goes, and fitted over the whole run. Mean ± spread (rms about the mean), µs; the mean is latency, which nobody can see in\n\
         one stream. Aligned: the delay of the synchronisation moves is subtracted; mean and spread of the remainder against the axes by MTConnect.\n\n"
    )
}

fn promises() -> String {
    let reported = |timer_s: f64| {
        let Promise { arrival_s, line_s: [least, middle, most] } = behind(timer_s);
        format!(
            "behind a timer of {:.0} ms {} become {} ({} to {})",
            timer_s * 1e3,
            duration(arrival_s),
            duration(middle),
            duration(least),
            duration(most)
        )
    };
    format!(
        "What arithmetic alone promises, computed by the same command: a probe at {:.0} Hz whose clock is off by {:.0} ppm, readings\n\
         ready {:.0} µs after they were taken (mean of an exponential), the line of a run of {:.0} s, {} runs with any phase between\n\
         probe and timer: {};\n\
         {} (spread of the arrivals; of the line: middle run, least and largest).\n\n",
        promise::PERIOD_S.recip(),
        promise::DRIFT * 1e6,
        promise::READY_S * 1e6,
        promise::SECONDS,
        promise::SEEDS,
        reported(0.016),
        reported(0.001)
    )
}

/// Two digits, in µs or ms.
fn duration(s: f64) -> String {
    let (number, unit) = if s < 1e-3 { (s * 1e6, "µs") } else { (s * 1e3, "ms") };
    let digits = (1.0 - number.abs().log10().floor()).max(0.0) as usize;
    format!("{number:.digits$} {unit}")
}

const REMARKS: &str = "\
A DL-RS1A refreshes its values every 13 ms and does not say when: 13 ms/√12 = 3.8 ms stay whatever is done. An indicator that\n\
takes its value anywhere in the 30 ms until its answer is stamped in the middle: 30 ms/√12 = 8.7 ms stay; one that latches at\n\
the request is stamped with it. linuxcncrsh renews its values every 10 ms and is asked every 4 ms: shorten `[TASK] CYCLE_TIME`.\n\
An OPC UA server reports changes only: while some axes are stationary, an instant is known once they report nothing for three samplings and\n\
20 ms, and that wait is in the mean.\n\n\
Behind a serial adapter the moment of a SYNC lies between its writing and the arrival of its values, and only the sum of the two\n\
waits is seen, which no line can share out. The writing is taken: a USB adapter lets the SYNC wait less than 1 ms before the bus and\n\
the values up to 16 ms behind it; here both wait for the same processors, so the arrival may come out better. The stamps\n\
an adapter can add (`Z1`) count whole milliseconds, and switching them on changes what it keeps in its EEPROM.\n\n";

const EMULATED: &str = "
## CAN interface of the kernel

`canopen-socketcan` needs a kernel with CAN; `tests/peers/run` boots one in an emulated computer with two emulated cards on one
bus, the driver on one of them, the simulated nodes on the other, and writes this table when TRUNNION_WRITE_DOCS is set. The
truth is the interrupt of the nodes' card for the SYNC, read from an encoder that moves one step in 5 µs; times are those of the emulated
computer.

";
