//! The truth about a virtual machine: everything that is wrong with it, and nothing else.
//!
//! Drawn from a seed, or read from the sealed truth file `format = "trunnion-truth/1"`.

mod draw;
mod errors;
mod file;
mod location;
mod mount;
mod mounting;
mod setup;

pub use errors::{Noise, Truth};

pub use setup::{Instrument, NestOn, Own, PlacedSetup, SimForm, SimSetup, SimTarget};

pub use location::{LocationError, NamedError, minimum_set};
