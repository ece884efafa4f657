//! Sessions and supervisor against the virtual devices, through real pseudo-terminals and sockets.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod agent_replies;
mod can;
mod controllers;
mod replies;
#[path = "../../../../tests/src/section.rs"]
mod section;
mod serial;
mod sessions;
mod shop;
mod whole_cycle;
