//! Laser ball bar, or one leg of a passive parallel link: `l = |p_tool − p_table| − z` over any distance [S2 §3.4].
//!
//! Three feet, one after the other or at once as a linkage, place the tool by trilateration; a foot is a setup. The zero z of the
//! length and the place of the foot are unknowns; a calibrated bar fixes `zero` at 0 in the model.
//! Limits: ideal balls, a straight bar.

use super::ball_bar::{reading, seen};
use crate::instrument::{Frame, Instrument, none, unturned};
use crate::settings::{known, offset, place};
use trunnion_core::InstrumentKind;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::LaserBallBar,
    settings: |setup| known(setup, place(), offset("zero", -1.0)),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: none,
};
