//! docs/alignment.md.

use crate::errors::{Error, StreamErrors};
use crate::floor::DEVICES;
use crate::world::{OMEGA, RADIUS_MM};
use std::fmt::Write;

/// The page.
pub fn page(streams: &[StreamErrors], seconds: f64) -> String {
    let um_per_us = OMEGA * RADIUS_MM * 1e-3;
    let mut page = format!(
        "# Alignment in time\n\n\
         How far the time of a sample is from the truth, measured on the simulated devices through real ports and the real drivers:\n\
         `cargo run --release -p trunnion-tests --bin alignment-trial -- --output docs/alignment.md` ({seconds:.0} s, all devices at once;\n\
         the figures are of the computer it ran on, written by that command). C turns at 3600°/min; at {RADIUS_MM} mm from it 1 µs is\n\
         {um_per_us:.3} µm of path. That is the cost where something is computed from axis positions and readings of different\n\
         instants. A reading of an R-test whose linear axes follow the ball costs only |de/dθ|·ω·δt, some hundred times less.\n\n\
         Stamped on arrival: when the bytes were read. Line: the lower hull of arrivals against the device's clock (`acquire::clock`),\n\
         as it goes, and fitted over the whole run. Mean ± spread (rms about the mean), µs; the mean is latency, which nobody can see in\n\
         one stream. Aligned: the delay of the sync gestures taken out; mean and spread of what is left against the axes.\n\n\
         What arithmetic alone promises for a clock off by 30 ppm: 4.6 ms behind a timer of 16 ms become 17 µs, 0.44 ms behind 1 ms become\n\
         0.4 µs. A DL-RS1A refreshes its values every 13 ms and does not say when: 13 ms/√12 = 3.8 ms stay whatever is done. Behind a serial\n\
         adapter a SYNC is stamped when it is written; what it waits there (here: for the simulator's task) stays. linuxcncrsh renews its\n\
         values every 10 ms and is asked every 4 ms: shorten `[TASK] CYCLE_TIME`. Not in the table: `canopen-socketcan` needs a kernel with\n\
         CAN and is measured in an emulated computer, `opcua` against a server of others; `tests/peers/run` prints their figures.\n\n\
         | device | transport | samples | stamped on arrival | line as it goes | line of the whole run | delay by gestures | aligned | path, on arrival → aligned |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    for (stream, (device, transport)) in streams.iter().zip(DEVICES) {
        let delay = stream
            .delay_s
            .map_or("—".into(), |(delay_s, u_s)| format!("{:.0} (u {:.0})", delay_s * 1e6, u_s * 1e6));
        let total = |error: Error| error.mean_s.hypot(error.rms_s) * 1e6 * um_per_us;
        let path = match stream.aligned {
            Some(aligned) => format!("{:.1} → {:.2} µm", total(stream.arrival), total(aligned)),
            None => format!(
                "{:.1} → {:.2} µm (spread)",
                stream.arrival.rms_s * 1e6 * um_per_us,
                stream.whole.rms_s * 1e6 * um_per_us
            ),
        };
        let row = format!(
            "| {device} | {transport} | {} | {} | {} | {} | {delay} | {} | {path} |",
            stream.samples,
            us(stream.arrival),
            us(stream.online),
            us(stream.whole),
            stream.aligned.map_or("—".into(), us)
        );
        writeln!(page, "{row}").expect("a string takes all text");
    }
    page
}

fn us(error: Error) -> String {
    format!("{:+.1} ± {:.1}", error.mean_s * 1e6, error.rms_s * 1e6)
}
