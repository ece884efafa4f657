//! MTConnect: the documents of an agent, the multipart stream of `/sample?interval=`, both sides.
//!
//! Elements are matched by local name, whatever version the namespace names. `UNAVAILABLE` is a value. A changed
//! `instanceId` means that the agent was restarted: probe again. Source: MTConnect Standard parts 1 to 3; written
//! documents use the namespaces of version 1.6.

mod document;
mod multipart;
mod read;
mod timestamp;
mod write;
mod xml;

pub use document::{
    AgentError, Category, Component, DataItem, Device, DevicesDocument, Document, DocumentError,
    ErrorDocument, Header, Observation, ObservedValue, StreamsDocument,
};
pub use multipart::{
    MAX_BODY_BYTES, MultipartDecoder, MultipartError, MultipartLosses, Part, boundary, encode_part,
};
pub use read::{element_name, parse};
pub use timestamp::{format_timestamp, parse_timestamp, timestamp};
pub use write::{write_devices, write_error, write_streams};
