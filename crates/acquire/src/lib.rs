//! Acquisition: from ports and networks to readings.
//!
//! [`config`] says which devices there are, [`drivers`] holds one *session* per kind (opens, identifies, reads, never
//! retries), [`supervisor`] keeps all of them alive and sends [`trunnion_core::reading::Message`]s through one bounded
//! queue. What readings become is `trunnion-sync`'s, shared with replay.

mod axis_name;
mod bar_zero;
pub mod config;
mod controller_stamp;
pub mod credentials;
pub mod discovery;
pub mod driver;
pub mod drivers;
pub mod execution;
pub mod link;
mod moments;
mod monitor;
pub mod probe;
mod session_end;
mod signal;
mod status;
pub mod supervisor;
#[cfg(test)]
mod test_clock;
pub mod transport;

pub use config::{DeviceConfig, parse_devices, read_devices};
pub use session_end::SessionEnd;
pub use status::{DeviceState, DeviceStatus};
pub use supervisor::{Acquisition, start};
