//! An indicator that says a value as a line, here the preset `mahr-c1202`; all presets share one driver.

use super::common::some;
use super::matrix::{Case, Cell, Kind, Subject, Trouble};
use trunnion_acquire::DeviceState::{Silent, WrongDevice};
use trunnion_hil_sim::devices::ascii::{IndicatorConfig, Sees};
use trunnion_hil_sim::devices::{Fault, ascii};
use trunnion_protocol::ascii::Preset;

const SILENT: &str = "silent for * ms: PORT does not answer *; check that it is switched on, its cable, and that this is its port";

pub const SUBJECT: Subject = Subject {
    driver: "ascii",
    about: "Mahr Millimar C 1202, as all presets",
    keys: "port = \"{port}\"\nsilence_ms = 1500\npoll_ms = 20\npreset = \"mahr-c1202\"\nrole = \"probe-1\"\n",
    start: |floor, _| {
        Box::pin(async move {
            let preset = *Preset::named("mahr-c1202").expect("a preset");
            let config = IndicatorConfig { answer_s: 0.015, ..IndicatorConfig::new(Sees::Probe(0), preset) };
            ascii::spawn(floor.world, config, &floor.port, floor.origin, &[]).expect("a good setting")
        })
    },
    kind: Kind::Serial,
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Silent => Case::silent(2.5, SILENT),
        Trouble::Garbled => Case::lost(Fault::GarbleBytes { count: 10 }, "answers were missing or damaged*"),
        Trouble::WrongIdentity => Case::another(
            &[Silent, WrongDevice],
            "silent for * ms: PORT does not answer *; * bytes came that make no sense at *: make `baud` that of the device; *",
            "wrong device: found a device that says \"HELLO 17\", expected *; correct the port or the configuration",
        ),
        // It trembles less often than the others: one answer in 20 ms.
        Trouble::StuckValue => Case { after_s: 13.0, ..Case::stuck(None, 400) },
        Trouble::OutOfRange => Case::out_of_range(None, "*the instrument reports an error*"),
        _ => return None,
    })
}
