//! Tracking interferometer: `l = |p_reflector − p_station| − l₀` [S2 §3.5, eq. 8].
//!
//! The station stands on the table (or on what does not move against it), the reflector rides in the spindle. Its zero lies
//! anywhere: l₀, the dead path, is an unknown of each station, as is where the station stands.
//! Limits: an ideal sphere as the station's reference; air and wavelength compensated before.

use super::ball_bar::{reading, seen};
use crate::instrument::{Frame, Instrument, none, unturned};
use crate::settings::{offset, place};
use trunnion_core::InstrumentKind;

pub(crate) const INSTRUMENT: Instrument = Instrument {
    kind: InstrumentKind::Tracker,
    settings: |_| place().into_iter().chain([offset("dead-path", -1.0)]).collect(),
    reading,
    seen,
    turned: unturned,
    frame: |_| Frame::Machine,
    inner: none,
};
