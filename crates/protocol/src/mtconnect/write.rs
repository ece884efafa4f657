//! The documents an agent writes, for simulated controllers. Namespaces are those of version 1.6, the
//! last whose agents need not describe themselves as a device.

use super::document::{
    Category, Component, DataItem, Device, DevicesDocument, ErrorDocument, Header, Observation,
    ObservedValue, StreamsDocument,
};
use super::timestamp::format_timestamp;
use quick_xml::escape::escape;

/// The document for `/probe`. Linear and rotary axes are put under `Axes`, other components under the device.
pub fn write_devices(document: &DevicesDocument) -> String {
    let devices: String = document.devices.iter().map(device).collect();
    let header = header(&document.header, &[("assetBufferSize", 8), ("assetCount", 0)]);
    envelope("MTConnectDevices", &header, &format!("<Devices>{devices}</Devices>"))
}

/// The document for `/current` and `/sample`. Consecutive observations of one component and category share its
/// elements.
pub fn write_streams(document: &StreamsDocument) -> String {
    let sequences = [
        ("nextSequence", document.next_sequence),
        ("firstSequence", document.first_sequence),
        ("lastSequence", document.last_sequence),
    ];
    let of_device = |group: &[Observation]| {
        let name = attribute("name", &group[0].device);
        let inner: String =
            group.chunk_by(|a, b| a.component_id == b.component_id).map(component_stream).collect();
        format!("<DeviceStream{name}{}>{inner}</DeviceStream>", attribute("uuid", &group[0].device))
    };
    let inner: String = document.observations.chunk_by(|a, b| a.device == b.device).map(of_device).collect();
    envelope(
        "MTConnectStreams",
        &header(&document.header, &sequences),
        &format!("<Streams>{inner}</Streams>"),
    )
}

/// The document for a refusal.
pub fn write_error(document: &ErrorDocument) -> String {
    let error = |error: &super::AgentError| {
        format!("<Error{}>{}</Error>", attribute("errorCode", &error.code), escape(error.text.as_str()))
    };
    let errors: String = document.errors.iter().map(error).collect();
    envelope("MTConnectError", &header(&document.header, &[]), &format!("<Errors>{errors}</Errors>"))
}

fn envelope(root: &str, header: &str, body: &str) -> String {
    let kind = root.trim_start_matches("MTConnect");
    let space = format!("urn:mtconnect.org:{root}:1.6");
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{root} xmlns:m=\"{space}\" xmlns=\"{space}\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"{space} http://schemas.mtconnect.org/schemas/MTConnect{kind}_1.6.xsd\">\
         {header}{body}</{root}>\n"
    )
}

fn header(header: &Header, numbers: &[(&str, u64)]) -> String {
    let mut text = format!("<Header{}", attribute("instanceId", &header.instance_id.to_string()));
    text += &attribute("sender", &header.sender);
    if let Some(ns) = header.creation_time_ns {
        text += &attribute("creationTime", &format_timestamp(ns));
    }
    text += &attribute("version", &header.version);
    text += &attribute("bufferSize", &header.buffer_size.to_string());
    for (name, number) in numbers {
        text += &attribute(name, &number.to_string());
    }
    text + "/>"
}

fn device(device: &Device) -> String {
    let groups: Vec<&[DataItem]> = device.data_items.chunk_by(|a, b| a.component == b.component).collect();
    let items = |group: &[DataItem]| {
        format!("<DataItems>{}</DataItems>", group.iter().map(data_item).collect::<String>())
    };
    let of_kind = |keep: &dyn Fn(&Component) -> bool| -> String {
        let kept = groups.iter().filter(|group| keep(&group[0].component));
        kept.map(|group| component(&group[0].component, &items(group))).collect()
    };
    let is_device = |part: &Component| part.kind == "Device";
    let is_axis = |part: &Component| matches!(part.kind.as_str(), "Linear" | "Rotary");
    let own: String =
        groups.iter().filter(|group| is_device(&group[0].component)).map(|group| items(group)).collect();
    let axes = of_kind(&is_axis);
    let others = of_kind(&|part| !is_axis(part) && !is_device(part));
    let axes = if axes.is_empty() {
        axes
    } else {
        format!(
            "<Axes id=\"{}-axes\" name=\"base\"><Components>{axes}</Components></Axes>",
            escape(device.id.as_str())
        )
    };
    let attributes = [("id", &device.id), ("name", &device.name), ("uuid", &device.uuid)]
        .map(|(n, v)| attribute(n, v))
        .concat();
    format!("<Device{attributes}>{own}<Components>{axes}{others}</Components></Device>")
}

fn component(component: &Component, inner: &str) -> String {
    let kind = &component.kind;
    format!(
        "<{kind}{}{}>{inner}</{kind}>",
        attribute("id", &component.id),
        attribute("name", &component.name)
    )
}

fn data_item(item: &DataItem) -> String {
    let category = match item.category {
        Category::Sample => "SAMPLE",
        Category::Event => "EVENT",
        Category::Condition => "CONDITION",
    };
    let mut text = format!("<DataItem{}{}", attribute("category", category), attribute("id", &item.id));
    text += &attribute("type", &item.kind);
    let optional = [
        ("name", &item.name),
        ("subType", &item.sub_type),
        ("units", &item.units),
        ("coordinateSystem", &item.coordinate_system),
    ];
    for (name, value) in optional {
        text += &value.as_ref().map(|value| attribute(name, value)).unwrap_or_default();
    }
    text + "/>"
}

fn component_stream(group: &[Observation]) -> String {
    let of_category = |group: &[Observation]| {
        let list = match group[0].category {
            Category::Sample => "Samples",
            Category::Event => "Events",
            Category::Condition => "Condition",
        };
        format!("<{list}>{}</{list}>", group.iter().map(observation).collect::<String>())
    };
    let inner: String = group.chunk_by(|a, b| a.category == b.category).map(of_category).collect();
    let of = attribute("component", &group[0].component) + &attribute("componentId", &group[0].component_id);
    format!("<ComponentStream{of}>{inner}</ComponentStream>")
}

fn observation(observation: &Observation) -> String {
    let kind = &observation.kind;
    let mut text = format!("<{kind}{}", attribute("dataItemId", &observation.data_item_id));
    text += &attribute("timestamp", &format_timestamp(observation.timestamp_ns));
    text += &observation.sub_type.as_ref().map(|value| attribute("subType", value)).unwrap_or_default();
    text += &attribute("sequence", &observation.sequence.to_string());
    let value = match &observation.value {
        ObservedValue::Unavailable if observation.category == Category::Condition => String::new(),
        ObservedValue::Unavailable => "UNAVAILABLE".into(),
        ObservedValue::Number(number) => number.to_string(),
        ObservedValue::Text(text) => text.clone(),
    };
    format!("{text}>{}</{kind}>", escape(value.as_str()))
}

fn attribute(name: &str, value: &str) -> String {
    format!(" {name}=\"{}\"", escape(value))
}
