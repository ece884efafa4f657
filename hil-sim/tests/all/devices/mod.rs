//! Virtual devices read through real pseudo-terminals and sockets.

mod agent;
mod bus;
mod client;
mod floor;
mod probe;
