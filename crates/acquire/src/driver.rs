//! What a driver is: a name for `trunnion.toml`, how its keys are read, and a session.
//!
//! A session opens, identifies the device, reads, and ends with a reason. It never retries: that is the
//! supervisor's work. Dropping a session at any await is safe; the port is closed with it.

use crate::link::Link;
use crate::probe::Probe;
use crate::session_end::SessionEnd;
use std::convert::Infallible;
use std::fmt::Debug;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::Role;
use trunnion_core::input::Table;

/// A session under way; it ends with a reason only.
pub type Session<'a> = Pin<Box<dyn Future<Output = Result<Infallible, SessionEnd>> + Send + 'a>>;

/// A configured device: what a driver makes of its table.
pub trait Device: Debug + Send + Sync {
    /// Channels of the device: name suffix (empty when there is one) and role.
    fn channels(&self) -> Vec<(String, Role)>;
    /// Measuring range of the displacement channels, mm, where the configuration says it.
    fn range_mm(&self) -> Option<[f64; 2]> {
        None
    }
    /// What the channel with the role bar shows at the length of the bar, mm, where the configuration says it; what it reads
    /// counts from there.
    fn bar_zero_mm(&self) -> Option<f64> {
        None
    }
    /// Time between two questions for a displacement, where the configuration says it.
    fn asked_every(&self) -> Option<Duration> {
        None
    }
    /// Port or address, for messages and to find two devices on one port.
    fn address(&self) -> &str;
    /// One connection, from opening to its end.
    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a>;
}

/// One kind of device.
pub struct Driver {
    /// Name in `trunnion.toml`; the file is named after it, `-` as `_`.
    pub name: &'static str,
    /// One line for `trunnion devices`.
    pub about: &'static str,
    /// `silence_ms` when the table has none.
    pub default_silence_ms: f64,
    /// Reads the driver's keys, noting problems.
    pub read: fn(&Table<'_>) -> Option<Arc<dyn Device>>,
    /// How `trunnion devices` finds one; `None` when nothing harmless can be asked.
    pub probe: Option<Probe>,
}
