//! Sans-I/O codecs of the devices Trunnion reads, one file per protocol, host side and device side.
//!
//! The host side serves the drivers, the device side serves simulated devices; both share the types, so that a
//! frame has one definition. Nothing here opens a port, waits, or reads a clock.
//!
//! Invariants, checked by property tests:
//! - no input makes a codec panic, and no input makes it keep more than a bounded amount of memory;
//! - a byte stream decodes the same however it is split;
//! - nothing is dropped in silence: garbage, lost synchronisation and damaged messages are counted.

pub mod ascii;
pub mod can;
pub mod canopen;
pub mod keyence;
pub mod lines;
pub mod linuxcncrsh;
pub mod mtconnect;
pub mod optoncdt;
pub mod slcan;
