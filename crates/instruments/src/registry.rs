//! One file per instrument, one line here.

mod ball_bar;
mod ball_plate;
mod cross_grid;
mod diagonal;
mod laser_ball_bar;
mod laser_tracker;
mod level;
mod machined_surface;
mod passive_arm;
mod r_test;
mod step_diagonal;
mod touch_probe;
mod touch_probe_face;
mod tracker;

use crate::Instrument;
use trunnion_core::InstrumentKind;

/// Every instrument.
pub static REGISTRY: &[Instrument] = &[
    r_test::INSTRUMENT,
    ball_bar::INSTRUMENT,
    tracker::INSTRUMENT,
    laser_tracker::INSTRUMENT,
    laser_ball_bar::INSTRUMENT,
    passive_arm::INSTRUMENT,
    cross_grid::INSTRUMENT,
    level::INSTRUMENT,
    diagonal::INSTRUMENT,
    step_diagonal::INSTRUMENT,
    ball_plate::INSTRUMENT,
    touch_probe::INSTRUMENT,
    touch_probe_face::INSTRUMENT,
    machined_surface::INSTRUMENT,
];

/// The instrument of a setup.
pub fn instrument(kind: InstrumentKind) -> &'static Instrument {
    REGISTRY.iter().find(|instrument| instrument.kind == kind).expect("every kind is registered (tested)")
}
