//! Virtual devices read through real pseudo-terminals and sockets.

#![expect(clippy::unwrap_used, reason = "a helper of a test fails the test like the test itself")]

mod agent;
mod bus;
mod client;
mod floor;
mod probe;
