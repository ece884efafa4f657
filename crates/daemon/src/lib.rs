//! The service: configuration, wiring of devices to recording to analysis, MQTT status.

pub mod analysis;
pub mod clock;
pub mod config;
pub mod forming;
pub mod live;
pub mod mqtt;
pub mod page;
pub mod plan;
pub mod recording;
pub mod service;
pub mod timing;
