//! MTConnect documents: hand-written ones in the forms agents of several versions send, and our own written ones.

use proptest::prelude::*;
use trunnion_protocol::mtconnect::*;

/// Structure and attributes as in the standard, part 2, and in documents of the C++ agent (prefix, no prefix).
const PROBE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<m:MTConnectDevices xmlns:m="urn:mtconnect.org:MTConnectDevices:1.3" xmlns="urn:mtconnect.org:MTConnectDevices:1.3">
  <Header creationTime="2010-04-06T06:19:35Z" sender="localhost" instanceId="1270534765" bufferSize="131072" version="1.3"/>
  <Devices>
    <Device id="d1" name="VMC-5Axis" uuid="000">
      <Description manufacturer="A &amp; B"/>
      <DataItems><DataItem type="AVAILABILITY" category="EVENT" id="avail" name="avail"/></DataItems>
      <Components>
        <Axes id="ax" name="base"><Components>
          <Linear id="x" name="X"><DataItems>
            <DataItem type="POSITION" subType="ACTUAL" category="SAMPLE" id="x2" name="Xact" units="MILLIMETER" nativeUnits="MILLIMETER" coordinateSystem="MACHINE"><Source>X</Source></DataItem>
            <DataItem type="POSITION" category="CONDITION" id="x9"/>
          </DataItems></Linear>
          <Rotary id="c" name="C"><DataItems>
            <DataItem type="ANGLE" subType="ACTUAL" category="SAMPLE" id="c2" units="DEGREE"/>
          </DataItems></Rotary>
        </Components></Axes>
      </Components>
    </Device>
  </Devices>
</m:MTConnectDevices>"#;

const SAMPLE: &str = r#"<MTConnectStreams xmlns="urn:mtconnect.org:MTConnectStreams:2.0">
  <Header instanceId="7" sender="a" nextSequence="43" firstSequence="1" lastSequence="42" bufferSize="131072" creationTime="2024-02-29T23:59:59Z" version="2.0.0.1"/>
  <Streams><DeviceStream name="VMC-5Axis" uuid="000">
    <ComponentStream component="Linear" name="X" componentId="x">
      <Samples><Position dataItemId="x2" timestamp="2024-02-29T23:59:59.123456Z" sequence="41" subType="ACTUAL">-12.5</Position></Samples>
      <Condition><Unavailable dataItemId="x9" timestamp="2024-02-29T23:59:59Z" sequence="12" type="POSITION"/></Condition>
    </ComponentStream>
    <ComponentStream component="Rotary" name="C" componentId="c">
      <Samples><Angle dataItemId="c2" timestamp="2024-02-29T23:59:59.123456Z" sequence="42">UNAVAILABLE</Angle></Samples>
      <Events><Program dataItemId="p" timestamp="2024-02-29T23:59:59Z" sequence="13">A&lt;B &#65;</Program></Events>
    </ComponentStream>
  </DeviceStream></Streams>
</MTConnectStreams>"#;

#[test]
fn a_probe_lists_every_data_item_with_its_component() {
    let Document::Devices(document) = parse(PROBE.as_bytes()).unwrap() else { panic!("no devices document") };
    assert_eq!(document.header.instance_id, 1_270_534_765);
    let device = &document.devices[0];
    assert_eq!((device.id.as_str(), device.name.as_str()), ("d1", "VMC-5Axis"));
    let found: Vec<_> = device
        .data_items
        .iter()
        .map(|item| {
            let component = &item.component;
            (
                item.id.as_str(),
                item.kind.as_str(),
                item.sub_type.as_deref(),
                component.kind.as_str(),
                component.name.as_str(),
            )
        })
        .collect();
    assert_eq!(
        found,
        [
            ("avail", "AVAILABILITY", None, "Device", "VMC-5Axis"),
            ("x2", "POSITION", Some("ACTUAL"), "Linear", "X"),
            ("x9", "POSITION", None, "Linear", "X"),
            ("c2", "ANGLE", Some("ACTUAL"), "Rotary", "C"),
        ]
    );
    assert_eq!(device.data_items[1].units.as_deref(), Some("MILLIMETER"));
    assert_eq!(device.data_items[2].category, Category::Condition);
}

#[test]
fn a_sample_gives_values_times_and_the_next_sequence() {
    let Document::Streams(document) = parse(SAMPLE.as_bytes()).unwrap() else {
        panic!("no streams document")
    };
    assert_eq!((document.first_sequence, document.last_sequence, document.next_sequence), (1, 42, 43));
    let found: Vec<_> = document
        .observations
        .iter()
        .map(|o| (o.data_item_id.as_str(), o.sequence, o.value.clone()))
        .collect();
    assert_eq!(
        found,
        [
            ("x2", 41, ObservedValue::Number(-12.5)),
            ("x9", 12, ObservedValue::Unavailable),
            ("c2", 42, ObservedValue::Unavailable),
            ("p", 13, ObservedValue::Text("A<B A".into())),
        ]
    );
    assert_eq!(document.observations[0].timestamp_ns, 1_709_251_199_123_456_000);
}

#[test]
fn out_of_range_is_recognised_in_old_and_new_forms() {
    let check = |body: &str| {
        let text = format!("<MTConnectError><Header instanceId=\"1\"/>{body}</MTConnectError>");
        let Document::Error(document) = parse(text.as_bytes()).unwrap() else { panic!("no error document") };
        assert!(document.is_out_of_range());
        assert_eq!(document.errors[0].text, "'from' must be greater than 5");
    };
    check(r#"<Error errorCode="OUT_OF_RANGE">'from' must be greater than 5</Error>"#);
    check(r#"<Errors><Error errorCode="OUT_OF_RANGE">'from' must be greater than 5</Error></Errors>"#);
    check(
        r#"<Errors><OutOfRange errorCode="OUT_OF_RANGE"><ErrorMessage>'from' must be greater than 5</ErrorMessage></OutOfRange></Errors>"#,
    );
}

#[test]
fn broken_documents_are_refused_with_the_reason() {
    let check =
        |text: &str, expected: &str| assert_eq!(parse(text.as_bytes()).unwrap_err().to_string(), expected);
    check("", "the document is empty");
    check(&SAMPLE[..SAMPLE.len() - 20], "the document ends before its last element does");
    check("<html/>", "<html> is not an MTConnect devices, streams or error document");
    check(
        &SAMPLE.replace("sequence=\"41\"", "sequence=\"-\""),
        "<Position> has sequence=\"-\"; expected a whole number",
    );
    check(&"<a>".repeat(100_000), "the document nests elements deeper than any MTConnect document");
}

#[test]
fn an_axis_angle_element_is_named_after_its_type() {
    assert_eq!(element_name("POSITION"), "Position");
    assert_eq!(element_name("PATH_FEEDRATE"), "PathFeedrate");
}

fn header() -> Header {
    Header {
        instance_id: 7,
        sender: "trunnion <sim> & co".into(),
        creation_time_ns: Some(1_709_251_199_000_000_001),
        version: "1.8.0".into(),
        buffer_size: 131_072,
    }
}

#[test]
fn written_devices_are_read_back() {
    let Document::Devices(mut document) = parse(PROBE.as_bytes()).unwrap() else {
        panic!("no devices document")
    };
    document.header = header();
    assert_eq!(parse(write_devices(&document).as_bytes()).unwrap(), Document::Devices(document));
}

#[test]
fn a_written_error_is_read_back() {
    let errors = vec![AgentError { code: "OUT_OF_RANGE".into(), text: "'from' < 5 & \"old\"".into() }];
    let document = ErrorDocument { header: header(), errors };
    assert_eq!(parse(write_error(&document).as_bytes()).unwrap(), Document::Error(document));
}

fn any_value() -> impl Strategy<Value = (Category, ObservedValue)> {
    prop_oneof![
        (-1e6..1e6f64).prop_map(|number| (Category::Sample, ObservedValue::Number(number))),
        Just((Category::Sample, ObservedValue::Unavailable)),
        "[a-z<>&\"' éµ]{0,12}[a-z]"
            .prop_map(|text| (Category::Event, ObservedValue::Text(text.trim().into()))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn written_streams_are_read_back(
        values in prop::collection::vec((any_value(), any::<i64>(), any::<u64>(), 0u8..3), 0..12),
    ) {
        let observations = values
            .into_iter()
            .map(|((category, value), timestamp_ns, sequence, component)| Observation {
                data_item_id: format!("item{component}"),
                device: "VMC".into(),
                component: "Linear".into(),
                component_id: format!("component{component}"),
                category,
                kind: "Position".into(),
                sub_type: (component == 1).then(|| "ACTUAL".to_owned()),
                sequence,
                timestamp_ns,
                value,
            })
            .collect();
        let document = StreamsDocument {
            header: header(), first_sequence: 1, last_sequence: 9, next_sequence: 10, observations,
        };
        prop_assert_eq!(parse(write_streams(&document).as_bytes()).unwrap(), Document::Streams(document));
    }

    #[test]
    fn no_damage_to_a_document_makes_the_parser_panic(
        at in any::<prop::sample::Index>(), byte in any::<u8>(), cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = SAMPLE.as_bytes().to_vec();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        bytes.truncate(cut.index(bytes.len()) + 1);
        drop(parse(&bytes));
    }
}

#[test]
fn a_document_of_endless_elements_or_attributes_is_refused() {
    let shown = |text: String| parse(text.as_bytes()).unwrap_err().to_string();
    let refused = "the document has more than 500000 elements and attributes";
    assert_eq!(shown(format!("<a>{}</a>", "<b/>".repeat(500_000))), refused);
    let attributes: String = (0..1000).map(|k| format!(" a{k}=\"\"")).collect();
    assert_eq!(shown(format!("<a>{}</a>", format!("<b{attributes}/>").repeat(500))), refused);
}
