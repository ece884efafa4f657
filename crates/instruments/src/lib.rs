//! Observation models: what an instrument sees of the machine, exactly and to first order.
//!
//! Both forms are given the same errors by site; [`Projector::column`] is the derivative of [`predict`] at zero
//! errors (a test holds them together). One file per instrument, one line in [`REGISTRY`].

mod instrument;
mod projector;
mod registry;
mod settings;

pub use instrument::Instrument;
pub use projector::{Projector, predict};
pub use registry::{REGISTRY, instrument};
pub use settings::{Quantity, Setting, off_spindle};

#[cfg(test)]
mod tests;
