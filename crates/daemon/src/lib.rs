//! The service: configuration, wiring of devices to recording to analysis, MQTT status.

pub mod mqtt;
