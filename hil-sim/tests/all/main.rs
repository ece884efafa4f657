//! The integration tests of this crate: virtual devices and the physics of the virtual machine.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod devices;
mod physics;
