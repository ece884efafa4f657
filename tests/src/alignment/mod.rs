//! How far the times of samples are from the truth: a world that shows its time, the errors of every sample four ways of
//! timing it, and how they are shown. Used where the devices are (the trial), and where a kernel has CAN (the guest).

mod errors;
mod read;
mod row;
mod world;

pub use errors::{Error, StreamErrors, Truth, of};
pub use read::read;
pub use row::{HEAD, row};
pub use world::{ClockWorld, MARGIN_S, OMEGA, RADIUS_MM};

/// Name of the section of docs/measured/alignment.md that the emulated computer writes.
pub const SOCKETCAN: &str = "canopen-socketcan";
