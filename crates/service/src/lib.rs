//! The service: configuration, wiring of devices to recording to analysis, MQTT status.

pub mod analysis;
pub mod board;
pub mod caller;
pub mod child;
pub mod clock;
pub mod config;
pub mod cycles;
pub mod daemon;
mod error;
mod found;
mod kept_story;
pub mod latest;
pub mod live;
pub mod mqtt;
pub mod mtconnect;
pub mod nest_file;
pub mod opcua;
pub mod operator;
pub mod page;
mod pem;
pub mod plant;
pub mod print;
pub mod private_files;
mod recording;
pub mod run_record;
pub mod set_up;
pub mod storage;
