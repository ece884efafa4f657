//! Lawicel (slcan) serial CAN adapters: ASCII lines ending in CR.
//!
//! Host to adapter: `Sn` bit rate (while closed), `O` `L` `C` open, listen, close, `Z0` `Z1` time stamps, `F` `V`
//! `N` status, version, serial number, `tiiildd…` `Tiiiiiiiildd…` data frame, `riiil` `Riiiiiiiil` remote request.
//! Adapter to host: CR done, BEL (07h, without CR) refused, `z` `Z` frame accepted, and frames in the same form,
//! with four more hex digits when time stamps are on (milliseconds modulo 60 000).
//! Source: Lawicel CAN232 and CANUSB manuals; EasySYNC USB2-F-7x01 guide §4.1.5 (stamp range 0000h..EA5Fh).

mod adapter;
mod message;
#[cfg(test)]
mod tests;

pub use message::{AdapterDecoder, AdapterMessage, Bitrate, HostCommand, HostDecoder, Losses, StatusFlags};

pub use adapter::Adapter;
