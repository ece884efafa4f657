//! optoNCDT 1420: streams on its own, with a counter and a clock.

use super::common::some;
use super::matrix::{Case, Cell, GapOf, Kind, Lost, Subject, Trouble};
use trunnion_acquire::DeviceState::{Silent, WrongDevice};
use trunnion_hil_sim::devices::optoncdt::ProbeConfig;
use trunnion_hil_sim::devices::{DeviceClock, Fault, optoncdt};

const SILENT: &str = "silent for * ms: PORT sends no values*";
const LOST: &str = "values lost on the line (counter jumped)*";

pub const SUBJECT: Subject = Subject {
    driver: "optoncdt",
    about: "optoNCDT 1420 on RS422",
    keys: "port = \"{port}\"\nrole = \"probe-1\"\nrange_mm = 2\n",
    start: |floor, _| {
        Box::pin(async move {
            let config = ProbeConfig::new(0, DeviceClock::steady(50.0, 20.0));
            optoncdt::spawn(floor.world, config, &floor.port, floor.origin, &[]).expect("a good setting")
        })
    },
    kind: Kind::Serial,
    own,
};

fn own(trouble: Trouble) -> Option<Cell> {
    some(match trouble {
        Trouble::Silent => Case::silent(1.5, SILENT),
        Trouble::Garbled => Case::lost(Fault::GarbleBytes { count: 40 }, LOST),
        Trouble::WrongIdentity => Case::another(
            &[Silent, WrongDevice],
            SILENT,
            "wrong device: found ILD1420-50 serial *, expected an optoNCDT 1320 or 1420 with range 2 mm; correct the port \
             or the configuration",
        ),
        Trouble::StuckValue => Case::stuck(None, 400),
        Trouble::OutOfRange => Case::out_of_range(None, "*target behind the measuring range*"),
        Trouble::CounterJump => {
            let mut case = Case::lost(Fault::CounterJump { by: 77 }, LOST);
            case.gap = case.gap.map(|gap| GapOf { lost: Lost::Exactly(77), ..gap });
            case
        }
        Trouble::ClockJump => Case {
            fault: Some(Fault::ClockJump { by_s: -0.4 }),
            after_s: 2.5,
            gap: GapOf::away(
                "its clock was set by -0.4* s; times of readings between are uncertain by that much",
                0.9,
            ),
            ..Case::default()
        },
        _ => return None,
    })
}
