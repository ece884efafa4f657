//! Byte transports: serial ports and HTTP. Every wait has a limit; a failure is a [`crate::SessionEnd`].

pub mod http;
pub mod serial;
