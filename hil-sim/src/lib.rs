//! The virtual machine tool: physics of its own, and devices that speak the real protocols.

pub mod devices;
pub mod motion;
