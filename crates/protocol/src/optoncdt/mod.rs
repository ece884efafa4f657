//! Micro-Epsilon optoNCDT 1320 and 1420: RS422, 8N1, factory 921 600 baud, up to 4 kHz.
//!
//! The sensor streams binary values while it answers ASCII commands. A value of 18 bits is three bytes,
//! L `00 D5…D0`, M `01 D11…D6`, H `1 F D17…D12`, in this order only; F = 0 marks the first value of a block (the
//! distance), F = 1 the additional values chosen with `OUTADD_RS422`. ASCII has no byte with the top bit set, so
//! text can never complete a value.
//!
//! [`stream`] splits bytes into blocks and replies, [`values`] gives the numbers their meaning, [`command`] is the
//! ASCII part. Source: optoNCDT 1420 instruction manual §7.5.2 (values), §8.2 (data format), A 3 (commands).

pub mod command;
pub mod stream;
pub mod values;

pub use command::{Command, OutputField, Reply, SensorInfo};
pub use stream::{Block, BlockLength, Decoder, Event, RawValue, StreamCounts, encode_block};
pub use values::{DistanceError, Layout, Measurement, Unwrap, distance_mm, raw_distance};
