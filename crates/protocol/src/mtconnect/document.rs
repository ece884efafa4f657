//! The three documents of an agent: devices (`/probe`), streams (`/current`, `/sample`), error.

use thiserror::Error;

/// What an agent sent.
#[derive(Debug, Clone, PartialEq)]
pub enum Document {
    /// Answer to `/probe`.
    Devices(DevicesDocument),
    /// Answer to `/current` or `/sample`.
    Streams(StreamsDocument),
    /// Refusal.
    Error(ErrorDocument),
}

/// The header every document has.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// Changes when the agent is restarted: sequence numbers begin again and the devices may be others.
    pub instance_id: u64,
    /// Name of the agent.
    pub sender: String,
    /// When the document was made, ns since 1970 UTC, if it can be read.
    pub creation_time_ns: Option<i64>,
    /// Version of the agent.
    pub version: String,
    /// Observations the agent keeps.
    pub buffer_size: u64,
}

/// Devices and their data items.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DevicesDocument {
    /// Header.
    pub header: Header,
    /// Devices of the agent.
    pub devices: Vec<Device>,
}

/// One device.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Device {
    /// `id`.
    pub id: String,
    /// `name`.
    pub name: String,
    /// `uuid`.
    pub uuid: String,
    /// Data items of the device and all its components, in document order.
    pub data_items: Vec<DataItem>,
}

/// Part of a device that has data items: `Linear`, `Rotary`, `Controller`, `Path`, `Device` itself, ….
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Component {
    /// Element name.
    pub kind: String,
    /// `id`.
    pub id: String,
    /// `name`, `X` for an axis for example.
    pub name: String,
}

/// `category` of a data item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Category {
    /// Continuous value.
    Sample,
    /// Discrete value.
    Event,
    /// Fault state.
    Condition,
}

/// One data item.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataItem {
    /// `id`, referred to by observations.
    pub id: String,
    /// `name`, if it has one.
    pub name: Option<String>,
    /// `category`.
    pub category: Category,
    /// `type`, `POSITION` or `ANGLE` for example.
    pub kind: String,
    /// `subType`, `ACTUAL` or `COMMANDED` for example.
    pub sub_type: Option<String>,
    /// `units`, `MILLIMETER` or `DEGREE` for example.
    pub units: Option<String>,
    /// `coordinateSystem`, `MACHINE` or `WORK`.
    pub coordinate_system: Option<String>,
    /// The component it belongs to.
    pub component: Component,
}

/// Observations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StreamsDocument {
    /// Header.
    pub header: Header,
    /// Lowest sequence number the agent still has.
    pub first_sequence: u64,
    /// Highest sequence number the agent has.
    pub last_sequence: u64,
    /// Give this as `from` in the next request.
    pub next_sequence: u64,
    /// All observations, in document order (grouped by component, not by sequence).
    pub observations: Vec<Observation>,
}

/// One observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// `dataItemId`.
    pub data_item_id: String,
    /// Device `name`.
    pub device: String,
    /// `component`: kind of the component, `Linear`.
    pub component: String,
    /// `componentId`.
    pub component_id: String,
    /// Category, from the element it is in.
    pub category: Category,
    /// Element name: `Position`, for a condition `Normal`, `Warning`, `Fault`, `Unavailable`.
    pub kind: String,
    /// `subType`, if given.
    pub sub_type: Option<String>,
    /// `sequence`.
    pub sequence: u64,
    /// `timestamp`, ns since 1970 UTC.
    pub timestamp_ns: i64,
    /// The value.
    pub value: ObservedValue,
}

/// Value of an observation.
#[derive(Debug, Clone, PartialEq)]
pub enum ObservedValue {
    /// `UNAVAILABLE`: the agent knows no value, for example because its adapter is gone.
    Unavailable,
    /// A finite number of a sample.
    Number(f64),
    /// Any other text, trimmed.
    Text(String),
}

/// Refusal by an agent.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ErrorDocument {
    /// Header.
    pub header: Header,
    /// At least one error.
    pub errors: Vec<AgentError>,
}

/// One error of an agent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AgentError {
    /// `errorCode`: `OUT_OF_RANGE`, `NO_DEVICE`, `INVALID_XPATH`, ….
    pub code: String,
    /// The agent's words.
    pub text: String,
}

impl ErrorDocument {
    /// True when `from` lies outside the agent's buffer: ask `/current` and record a gap.
    pub fn is_out_of_range(&self) -> bool {
        self.errors.iter().any(|error| error.code == "OUT_OF_RANGE")
    }
}

/// Why bytes are not a document.
#[derive(Debug, Error)]
pub enum DocumentError {
    /// Not UTF-8.
    #[error("the document is not UTF-8 from byte {at} on")]
    NotUtf8 {
        /// Byte position.
        at: usize,
    },
    /// Not XML.
    #[error("the document is not well-formed XML at byte {at}")]
    Xml {
        /// Byte position.
        at: u64,
        /// What is wrong.
        source: quick_xml::Error,
    },
    /// Nested beyond any device model.
    #[error("the document nests elements deeper than any MTConnect document")]
    TooDeep,
    /// More than any device model or thousand observations.
    #[error("the document has more than {limit} elements and attributes")]
    TooMany {
        /// So many are read.
        limit: usize,
    },
    /// Ends before its last element does.
    #[error("the document ends before its last element does")]
    Truncated,
    /// No element.
    #[error("the document is empty")]
    Empty,
    /// Another kind of document.
    #[error("<{0}> is not an MTConnect devices, streams or error document")]
    NotMtConnect(String),
    /// An element is missing.
    #[error("<{parent}> has no <{child}>")]
    MissingElement {
        /// Where it should be.
        parent: String,
        /// What should be there.
        child: &'static str,
    },
    /// An attribute is missing.
    #[error("<{element}> has no {attribute}")]
    MissingAttribute {
        /// Where it should be.
        element: String,
        /// What should be there.
        attribute: &'static str,
    },
    /// An attribute that must be a whole number is none.
    #[error("<{element}> has {attribute}=\"{text}\"; expected a whole number")]
    WrongNumber {
        /// Element.
        element: String,
        /// Attribute.
        attribute: &'static str,
        /// What was found.
        text: String,
    },
    /// A time stamp cannot be read.
    #[error("<{element}> has timestamp=\"{text}\"; expected ISO 8601 such as 2010-04-06T06:19:35.153141Z")]
    WrongTimestamp {
        /// Element.
        element: String,
        /// What was found.
        text: String,
    },
    /// A category that is none of the three.
    #[error("data item {id} has category=\"{text}\"; expected SAMPLE, EVENT or CONDITION")]
    WrongCategory {
        /// Data item.
        id: String,
        /// What was found.
        text: String,
    },
}
