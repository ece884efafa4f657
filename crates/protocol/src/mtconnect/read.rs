//! Reading the documents from XML.

use super::document::{
    AgentError, Category, Component, DataItem, Device, DevicesDocument, Document, DocumentError,
    ErrorDocument, Header, Observation, ObservedValue, StreamsDocument,
};
use super::timestamp::parse_timestamp;
use super::xml::{Element, parse_tree};

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
        component: component.attribute("component").unwrap_or_default().to_owned(),
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
