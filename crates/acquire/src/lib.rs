//! Acquisition: from ports and networks to readings.
//!
//! [`config`] says which devices there are, [`drivers`] holds one *session* per kind (opens, identifies, reads, never
//! retries), [`supervisor`] keeps all of them alive and sends [`trunnion_core::reading::Message`]s through one bounded
//! queue. What readings become is `trunnion-sync`'s, shared with replay.

pub mod config;
pub mod discovery;
pub mod drivers;
pub mod probe;
pub mod supervisor;
pub mod transport;

pub use config::{DeviceConfig, parse_devices, read_devices};
pub use supervisor::{Acquisition, DeviceState, DeviceStatus, SessionEnd, start};
