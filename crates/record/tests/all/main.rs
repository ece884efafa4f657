//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use trunnion_core::HostTime;
use trunnion_cycles::RunKind;
use trunnion_record::RunHeader;

mod b5r;
mod damage;
mod full_disk;
mod full_rate;
mod gone_folder;
mod kill;
mod on_the_fly;
mod points;
mod round_trip;
mod schema;

/// A run on the fly of one probe, with nothing else in it.
fn header(name: &str, probe: &str) -> RunHeader {
    RunHeader {
        name: name.into(),
        kind: RunKind::OnTheFly,
        machine_name: "table-bc".into(),
        machine_text: String::new(),
        setups: Vec::new(),
        temperature_channels: Vec::new(),
        probes: vec![probe.into()],
        probe_roles: Vec::new(),
        cycle_text: String::new(),
        config_text: String::new(),
        software_version: "0.1.0".into(),
        wall_start_ns: 0,
        host_start: HostTime(0),
    }
}
