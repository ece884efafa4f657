//! The three documents a client reads: devices (`/probe`), streams (`/current`, `/sample`), error.

use super::timestamp::parse_timestamp;
use super::xml::{Element, parse_tree};
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
    /// Changes when the agent is restarted: sequence numbers begin anew and the devices may be others.
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

/// Reads a document.
pub fn parse(bytes: &[u8]) -> Result<Document, DocumentError> {
    let root = parse_tree(bytes)?;
    Ok(match root.name.as_str() {
        "MTConnectDevices" => Document::Devices(devices(&root)?),
        "MTConnectStreams" => Document::Streams(streams(&root)?),
        "MTConnectError" => Document::Error(errors(&root)?),
        _ => return Err(DocumentError::NotMtConnect(root.name)),
    })
}

/// Name of the element that carries observations of a data item type: `PATH_FEEDRATE` gives `PathFeedrate`.
pub fn element_name(kind: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|c| c.to_ascii_uppercase());
        first.into_iter().chain(letters.map(|c| c.to_ascii_lowercase())).collect::<String>()
    };
    kind.split('_').map(word).collect()
}

fn header(root: &Element) -> Result<(Header, &Element), DocumentError> {
    let element = child(root, "Header")?;
    let header = Header {
        instance_id: element.number("instanceId")?,
        sender: element.attribute("sender").unwrap_or_default().to_owned(),
        creation_time_ns: element.attribute("creationTime").and_then(parse_timestamp),
        version: element.attribute("version").unwrap_or_default().to_owned(),
        buffer_size: element.attribute("bufferSize").and_then(|size| size.parse().ok()).unwrap_or(0),
    };
    Ok((header, element))
}

fn child<'a>(parent: &'a Element, name: &'static str) -> Result<&'a Element, DocumentError> {
    parent
        .child(name)
        .ok_or_else(|| DocumentError::MissingElement { parent: parent.name.clone(), child: name })
}

fn devices(root: &Element) -> Result<DevicesDocument, DocumentError> {
    let mut devices = Vec::new();
    for element in &child(root, "Devices")?.children {
        let mut data_items = Vec::new();
        collect_data_items(element, &mut data_items)?;
        devices.push(Device {
            id: element.need("id")?.to_owned(),
            name: element.attribute("name").unwrap_or_default().to_owned(),
            uuid: element.attribute("uuid").unwrap_or_default().to_owned(),
            data_items,
        });
    }
    Ok(DevicesDocument { header: header(root)?.0, devices })
}

/// Data items of a component, then those of the components in it.
fn collect_data_items(component: &Element, found: &mut Vec<DataItem>) -> Result<(), DocumentError> {
    let this = || Component {
        kind: component.name.clone(),
        id: component.attribute("id").unwrap_or_default().to_owned(),
        name: component.attribute("name").unwrap_or_default().to_owned(),
    };
    for list in &component.children {
        match list.name.as_str() {
            "DataItems" => {
                for item in list.children.iter().filter(|item| item.name == "DataItem") {
                    found.push(data_item(item, this())?);
                }
            }
            "Components" => {
                for inner in &list.children {
                    collect_data_items(inner, found)?;
                }
            }
            _ => {} // descriptions, configurations, compositions, references: nothing to observe
        }
    }
    Ok(())
}

fn data_item(element: &Element, component: Component) -> Result<DataItem, DocumentError> {
    let id = element.need("id")?.to_owned();
    let category = match element.need("category")? {
        "SAMPLE" => Category::Sample,
        "EVENT" => Category::Event,
        "CONDITION" => Category::Condition,
        other => return Err(DocumentError::WrongCategory { id, text: other.to_owned() }),
    };
    let optional = |name| element.attribute(name).map(str::to_owned);
    Ok(DataItem {
        id,
        name: optional("name"),
        category,
        kind: element.need("type")?.to_owned(),
        sub_type: optional("subType"),
        units: optional("units"),
        coordinate_system: optional("coordinateSystem"),
        component,
    })
}

fn streams(root: &Element) -> Result<StreamsDocument, DocumentError> {
    let (header, numbers) = header(root)?;
    let mut observations = Vec::new();
    for device in &child(root, "Streams")?.children {
        for component in &device.children {
            for group in &component.children {
                let category = match group.name.as_str() {
                    "Samples" => Category::Sample,
                    "Events" => Category::Event,
                    "Condition" => Category::Condition,
                    _ => continue,
                };
                for element in &group.children {
                    observations.push(observation(device, component, category, element)?);
                }
            }
        }
    }
    Ok(StreamsDocument {
        first_sequence: numbers.number("firstSequence")?,
        last_sequence: numbers.number("lastSequence")?,
        next_sequence: numbers.number("nextSequence")?,
        header,
        observations,
    })
}

fn observation(
    device: &Element,
    component: &Element,
    category: Category,
    element: &Element,
) -> Result<Observation, DocumentError> {
    let timestamp = element.need("timestamp")?;
    let wrong =
        || DocumentError::WrongTimestamp { element: element.name.clone(), text: timestamp.to_owned() };
    Ok(Observation {
        data_item_id: element.need("dataItemId")?.to_owned(),
        device: device.attribute("name").unwrap_or_default().to_owned(),
        component_id: component.attribute("componentId").unwrap_or_default().to_owned(),
        category,
        kind: element.name.clone(),
        sub_type: element.attribute("subType").map(str::to_owned),
        sequence: element.number("sequence")?,
        timestamp_ns: parse_timestamp(timestamp).ok_or_else(wrong)?,
        value: observed_value(category, element),
    })
}

fn observed_value(category: Category, element: &Element) -> ObservedValue {
    let text = element.text.trim();
    let unavailable_condition = category == Category::Condition && element.name == "Unavailable";
    if text == "UNAVAILABLE" || unavailable_condition {
        return ObservedValue::Unavailable;
    }
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && category == Category::Sample);
    number.map_or_else(|| ObservedValue::Text(text.to_owned()), ObservedValue::Number)
}

fn errors(root: &Element) -> Result<ErrorDocument, DocumentError> {
    // Version 1.0 has one <Error> in the root; 2.6 names the elements after the error.
    let list = root.child("Errors").unwrap_or(root);
    let coded = list.children.iter().filter(|element| element.attribute("errorCode").is_some());
    let mut errors = Vec::new();
    for element in coded {
        let text = element.child("ErrorMessage").map_or(&element.text, |message| &message.text);
        errors.push(AgentError { code: element.need("errorCode")?.to_owned(), text: text.trim().to_owned() });
    }
    if errors.is_empty() {
        return Err(DocumentError::MissingElement { parent: list.name.clone(), child: "Error" });
    }
    Ok(ErrorDocument { header: header(root)?.0, errors })
}
