//! One line of the table of errors in time.

use super::errors::{Error, StreamErrors};
use super::world::{OMEGA, RADIUS_MM};

/// Head of the table.
pub const HEAD: &str = "\
| device | transport | samples | stamped on arrival | line as it goes | line of the whole run | delay by synchronisation moves | aligned | path, on arrival → aligned |
|---|---|---|---|---|---|---|---|---|
";

/// The line of one stream; where no synchronisation move shows the delay, the path is that of the spread alone.
pub fn row(device: &str, transport: &str, stream: &StreamErrors) -> String {
    let delay = |(delay_s, u_s): (f64, f64)| format!("{:.0} (u {:.0})", delay_s * 1e6, u_s * 1e6);
    let path_um = |error_s: f64| error_s * 1e3 * OMEGA * RADIUS_MM;
    let total_um = |error: Error| path_um(error.mean_s.hypot(error.rms_s));
    let path = match stream.aligned {
        Some(aligned) => format!("{:.1} → {:.2} µm", total_um(stream.arrival), total_um(aligned)),
        None => {
            format!("{:.1} → {:.2} µm (spread)", path_um(stream.arrival.rms_s), path_um(stream.whole.rms_s))
        }
    };
    format!(
        "| {device} | {transport} | {} | {} | {} | {} | {} | {} | {path} |\n",
        stream.samples,
        us(stream.arrival),
        us(stream.online),
        us(stream.whole),
        stream.delay_s.map_or("—".into(), delay),
        stream.aligned.map_or("—".into(), us)
    )
}

fn us(error: Error) -> String {
    format!("{:+.1} ± {:.1}", error.mean_s * 1e6, error.rms_s * 1e6)
}
