//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::time::Instant;
use trunnion_core::{Clock, HostTime};
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
    RunHeader { probes: vec![probe.into()], ..RunHeader::new(name, RunKind::OnTheFly, "table-bc") }
}

/// The clock of this computer.
struct Monotonic(Instant);

impl Clock for Monotonic {
    fn now(&self) -> HostTime {
        HostTime(self.0.elapsed().as_nanos() as i64)
    }
    fn wall_ns(&self) -> i64 {
        0
    }
}
