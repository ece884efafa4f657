//! The service: configuration, wiring of devices to recording to analysis, MQTT status.

pub mod analysis;
pub mod clock;
pub mod config;
pub mod live;
pub mod mqtt;
pub mod page;
pub mod recording;
pub mod service;
