//! Touch-trigger probe: centre of a sphere on the table, measured minus nominal, machine axes [S2 §4.3].
//!
//! `m = p_sphere − p_stylus`. The sphere is probed at indexed angles of the rotary axes.
//! Limits: the stylus is calibrated; scatter of the trigger is noise.

use super::ball_plate::{reading, seen};
use crate::instrument::{Frame, Instrument, none, unturned};
use crate::settings::place;
use trunnion_core::InstrumentKind;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::TouchProbe,
    settings: |_| place(),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: none,
};
