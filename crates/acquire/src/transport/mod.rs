//! Byte transports: serial ports, TCP and HTTP. Every wait has a limit; a failure is a [`crate::SessionEnd`].

pub mod asked;
pub mod http;
pub mod http_login;
pub mod serial;
pub mod tcp;
pub mod trouble;
