//! Virtual devices that speak the real protocols over real ports, each with a clock of its own.
//!
//! [`cell::start`] brings up a whole shop floor: three optoNCDT probes and a CANopen ball bar on pseudo-terminals, a
//! CNC as an MTConnect agent. Every device asks the same [`World`] what there is to see at its own sampling instants,
//! stamps it with its own [`DeviceClock`], and can be given [`Fault`]s. What a device does with bytes and instants is
//! plain code without I/O; [`serial`] and [`mtconnect`] run it in real time. A [`relay`] is the
//! network in front of a server.

pub mod ascii;
pub mod canopen;
pub mod cell;
mod clock;
mod cycles;
mod faults;
mod handle;
pub mod keyence;
pub mod linuxcncrsh;
pub mod mtconnect;
#[cfg(feature = "opcua")]
pub mod opcua;
pub mod optoncdt;
pub mod relay;
pub mod serial;
mod value_faults;
mod world;

pub use clock::{DeviceClock, TimeOrigin};
pub use faults::{Fault, ReplyFault, ScheduledFault};
pub use handle::{Address, DeviceError, Handle, InjectError};
pub use world::{CycleState, Later, SimulatedCell, World, orthogonal_nest};
