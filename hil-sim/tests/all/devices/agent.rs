//! The CNC as an MTConnect agent.

use super::client::{bounded, document, get};
use super::floor::{WALL_NS, cell};
use http_body_util::BodyExt;
use hyper::body::Incoming;
use std::collections::BTreeMap;
use trunnion_core::Joint;
use trunnion_hil_sim::devices::{DeviceClock, Fault, World};
use trunnion_protocol::mtconnect::{Document, MultipartDecoder, ObservedValue, StreamsDocument, parse};

async fn current(url: &str) -> StreamsDocument {
    match document(url, "/current").await {
        Document::Streams(document) => document,
        other => panic!("{other:?}"),
    }
}

fn value<'a>(document: &'a StreamsDocument, id: &str) -> &'a ObservedValue {
    &document.observations.iter().find(|o| o.data_item_id == id).unwrap().value
}

/// The next documents of a stream; empty at its end.
async fn next_documents(body: &mut Incoming, parts: &mut MultipartDecoder) -> Vec<Document> {
    while let Some(frame) = bounded("the stream", body.frame()).await {
        let Ok(frame) = frame else { return Vec::new() };
        let documents = parts.push(frame.data_ref().unwrap());
        if !documents.is_empty() {
            return documents.iter().map(|part| parse(&part.body).unwrap()).collect();
        }
    }
    Vec::new()
}

async fn stream(url: &str, from: u64) -> (Incoming, MultipartDecoder) {
    let response = get(url, &format!("/VMC-5Axis/sample?from={from}&interval=40&count=2000")).await;
    let kind = response.headers()["content-type"].to_str().unwrap().to_owned();
    (response.into_body(), MultipartDecoder::new(&kind).unwrap())
}

#[tokio::test]
async fn streamed_positions_are_the_trajectory_at_the_controllers_instants() {
    let directory = tempfile::tempdir().unwrap();
    // Two seconds behind and 1 % slow
    let clock = DeviceClock::steady(-2.0, -10_000.0);
    let (world, cell) =
        cell(directory.path(), |config| config.controller.as_mut().unwrap().0.clock = clock).await;
    let url = cell.controller.as_ref().unwrap().url().unwrap();
    let Document::Devices(devices) = document(url, "/probe").await else { panic!("no devices") };
    let axes: BTreeMap<String, Joint> = devices.devices[0]
        .data_items
        .iter()
        .filter_map(|item| Some((item.id.clone(), Joint::parse(&item.component.name)?)))
        .collect();
    assert_eq!(axes.len(), 5);

    let (mut body, mut parts) = stream(url, current(url).await.next_sequence).await;
    let mut expected_sequence = None;
    let mut lines: BTreeMap<i64, BTreeMap<Joint, f64>> = BTreeMap::new();
    while lines.len() < 200 {
        for document in next_documents(&mut body, &mut parts).await {
            let Document::Streams(mut document) = document else { panic!("{document:?}") };
            document.observations.sort_by_key(|observation| observation.sequence);
            for observation in document.observations {
                let sequence = observation.sequence;
                assert!(expected_sequence.is_none_or(|expected| sequence == expected), "nothing is left out");
                expected_sequence = Some(sequence + 1);
                if let (Some(&axis), ObservedValue::Number(number)) =
                    (axes.get(&observation.data_item_id), &observation.value)
                {
                    lines.entry(observation.timestamp_ns).or_default().insert(axis, *number);
                }
            }
            assert!(expected_sequence.is_none_or(|expected| expected == document.next_sequence));
        }
    }
    let cell_s = |wall_ns: i64| clock.cell_s((wall_ns - WALL_NS) as f64 * 1e-9);
    let mut moving = 0;
    for (&wall_ns, positions) in &lines {
        let t_s = cell_s(wall_ns);
        let truth = world.axes(t_s);
        for (&axis, &shown) in positions {
            let (truth, tolerance) = if axis.is_rotary() {
                // Half a step of 1e-5°, 1 µs at 57°/s
                (truth[axis].to_degrees(), 0.5e-5 + 6e-5)
            } else {
                // Half a step of 0.1 µm, 1 µs at 100 mm/s
                (truth[axis], 0.05e-3 + 0.11e-3)
            };
            assert!((shown - truth).abs() < tolerance, "{axis} {shown} {truth} at {t_s}");
        }
        moving += usize::from([Joint::X, Joint::Y, Joint::C].iter().all(|a| positions.contains_key(a)));
    }
    let standing = lines.values().filter(|positions| positions.contains_key(&Joint::Z)).count();
    assert!(standing <= 1, "an axis that stands is not observed again");
    assert!(moving > 100, "one time stamp for all axes that move: {moving}");
    // Between two lines the axes are where a straight line puts them, to r (ωh)²/8.
    let stamps: Vec<i64> = lines.keys().copied().collect();
    for pair in stamps.windows(2) {
        if let (Some(before), Some(after)) = (lines[&pair[0]].get(&Joint::X), lines[&pair[1]].get(&Joint::X))
        {
            let (from_s, to_s) = (cell_s(pair[0]), cell_s(pair[1]));
            if from_s < 0.6 {
                continue; // C starts to turn at 0.5 s
            }
            assert!((to_s - from_s - 0.008 / 0.99).abs() < 3e-6, "125 lines per second of its own clock");
            let truth = world.axes(0.5 * (from_s + to_s))[Joint::X];
            assert!((0.5 * (before + after) - truth).abs() < 1.1e-3);
        }
    }
    cell.shutdown().await;
}

#[tokio::test]
async fn a_restarted_agent_has_another_instance_and_forgets_its_sequence() {
    let directory = tempfile::tempdir().unwrap();
    let (_, cell) = cell(directory.path(), |config| {
        config.controller.as_mut().unwrap().0.buffer_size = 256;
    })
    .await;
    let agent = cell.controller.as_ref().unwrap();
    let url = agent.url().unwrap();
    let before = bounded("a full buffer", async {
        loop {
            let now = current(url).await;
            if now.first_sequence > 1 {
                return now;
            }
        }
    })
    .await;
    let Document::Error(error) = document(url, "/sample?from=1").await else { panic!("no error") };
    assert!(error.is_out_of_range());
    assert_eq!(value(&before, "program"), &ObservedValue::Text("O1000".into()));
    assert_eq!(value(&before, "execution"), &ObservedValue::Text("ACTIVE".into()));

    let (mut body, mut parts) = stream(url, before.next_sequence).await;
    assert!(!next_documents(&mut body, &mut parts).await.is_empty());
    agent.inject(Fault::AgentRestart).unwrap();
    while !next_documents(&mut body, &mut parts).await.is_empty() {} // until the connection is dropped
    let after = current(url).await;
    assert_ne!(after.header.instance_id, before.header.instance_id);
    assert!(after.next_sequence < before.next_sequence);
    let from = before.next_sequence + 100_000;
    let Document::Error(error) = document(url, &format!("/sample?from={from}")).await else { panic!() };
    assert!(error.is_out_of_range());
    cell.shutdown().await;
}

#[tokio::test]
async fn a_lost_controller_is_unavailable_and_a_lost_network_refuses() {
    let directory = tempfile::tempdir().unwrap();
    let (_, cell) = cell(directory.path(), |_| {}).await;
    let agent = cell.controller.as_ref().unwrap();
    let url = agent.url().unwrap();
    let becomes = async |wanted: ObservedValue| {
        bounded("another value", async {
            while value(&current(url).await, "mode") != &wanted {
                tokio::time::sleep(std::time::Duration::from_millis(5)).await;
            }
        })
        .await;
    };
    becomes(ObservedValue::Text("AUTOMATIC".into())).await;
    agent.inject(Fault::Silence { duration_s: 0.3 }).unwrap();
    becomes(ObservedValue::Unavailable).await;
    becomes(ObservedValue::Text("AUTOMATIC".into())).await;

    let before = current(url).await;
    let (mut body, mut parts) = stream(url, before.next_sequence).await;
    agent.inject(Fault::Unplug { duration_s: 0.2 }).unwrap();
    while !next_documents(&mut body, &mut parts).await.is_empty() {} // until the connection is dropped
    let after = current(url).await; // connects again once it can
    assert_eq!(after.header.instance_id, before.header.instance_id, "the agent itself went on");
    assert!(after.next_sequence > before.next_sequence);
    cell.shutdown().await;
}
