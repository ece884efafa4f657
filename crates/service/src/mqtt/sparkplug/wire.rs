//! The messages of Sparkplug B that are used here, by the numbers of their fields [Sparkplug 3.0 §6.4]; fields that are not here are
//! skipped when a payload is read.

use prost::{Message, Oneof};

/// What every message but STATE carries.
#[derive(Clone, PartialEq, Message)]
pub struct Payload {
    /// When it was sent, ms since 1970, UTC.
    #[prost(uint64, optional, tag = "1")]
    pub timestamp: Option<u64>,
    /// The metrics.
    #[prost(message, repeated, tag = "2")]
    pub metrics: Vec<WireMetric>,
    /// Number of the message in its session, modulo 256.
    #[prost(uint64, optional, tag = "3")]
    pub seq: Option<u64>,
}

/// A value with its name.
#[derive(Clone, PartialEq, Message)]
pub struct WireMetric {
    /// Its name; a slash makes a folder.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// When it had this value, ms since 1970, UTC.
    #[prost(uint64, optional, tag = "3")]
    pub timestamp: Option<u64>,
    /// Number of its type; in births alone.
    #[prost(uint32, optional, tag = "4")]
    pub datatype: Option<u32>,
    /// There is no value.
    #[prost(bool, optional, tag = "7")]
    pub is_null: Option<bool>,
    /// What is said of it, such as its unit.
    #[prost(message, optional, tag = "9")]
    pub properties: Option<Properties>,
    /// The value.
    #[prost(oneof = "WireValue", tags = "11, 13, 14, 15")]
    pub value: Option<WireValue>,
}

/// The types of value that are used here.
#[derive(Clone, PartialEq, Oneof)]
pub enum WireValue {
    /// Of type Int64, as two's complement.
    #[prost(uint64, tag = "11")]
    Long(u64),
    /// Of type Double.
    #[prost(double, tag = "13")]
    Double(f64),
    /// Of type Boolean.
    #[prost(bool, tag = "14")]
    Boolean(bool),
    /// Of type String.
    #[prost(string, tag = "15")]
    Text(String),
}

/// A PropertySet: names, and their values in the same order.
#[derive(Clone, PartialEq, Message)]
pub struct Properties {
    /// The names.
    #[prost(string, repeated, tag = "1")]
    pub keys: Vec<String>,
    /// The values.
    #[prost(message, repeated, tag = "2")]
    pub values: Vec<Property>,
}

/// A PropertyValue that is a text.
#[derive(Clone, PartialEq, Message)]
pub struct Property {
    /// Number of its type.
    #[prost(uint32, optional, tag = "1")]
    pub kind: Option<u32>,
    /// The value.
    #[prost(string, optional, tag = "8")]
    pub text: Option<String>,
}
