//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod adequate;
mod alarms;
mod attributed;
mod calibration;
mod changes;
mod collinear_day;
mod conformity;
mod examples;
mod forecast;
mod good_runs;
mod joined;
mod kept;
mod lengths;
mod library;
mod likenesses;
mod linear;
mod lone_readings;
mod losses;
mod mistakes;
mod nest;
mod no_share;
mod one_answer;
mod other_machine;
mod periods;
mod plausible;
mod replayed;
mod resting;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../../tests/src/section.rs"]
mod section;
mod undecided;
mod values;
mod whole;

use trunnion_core::Role;
use trunnion_cycles::{Cycle, RunKind};
use trunnion_machine::shipped;
use trunnion_record::RunHeader;

/// Of a run at rest on the shipped table B-C, measured with three probes by this cycle.
fn header(name: &str, cycle_text: &str) -> RunHeader {
    let machine = shipped::machine("table-bc").unwrap();
    RunHeader {
        machine_text: trunnion::files::machine_text(&machine.name).unwrap(),
        setups: Cycle::parse("c.toml", cycle_text).unwrap().setups,
        probes: (1..=3).map(|k| format!("probe-{k}")).collect(),
        probe_roles: (0..3).map(Role::Probe).collect(),
        cycle_text: cycle_text.into(),
        ..RunHeader::new(name, RunKind::Static, &machine.name)
    }
}
