//! SDO: reading and writing objects of a node, expedited (up to 4 bytes) and segmented (CiA 301 §7.2.4).
//! Requests go to 600h+id, answers come from 580h+id, every frame has eight bytes:
//! command, index low, index high, sub-index, four bytes of data, or for segments command and seven bytes of data.

mod client;
mod message;
mod server;

pub use client::{SdoProgress, SdoTransfer};
pub use message::{AbortCode, MAX_OBJECT_BYTES, SdoError};
pub use server::{ObjectDictionary, SdoServer};
