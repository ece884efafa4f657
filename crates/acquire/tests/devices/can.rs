//! CAN sessions against the virtual bus, and what is reported where there is none.

use crate::shop::{SinceStart, find, gap_of_the_next_connection, next, read, state, until, until_message};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion_acquire::discovery::{Place, Roles, look};
use trunnion_acquire::{Acquisition, DeviceState, SessionEnd, parse_devices};
use trunnion_core::AxisValues;
use trunnion_core::reading::{Message, ProbeReading, Reading, TemperatureReading};
use trunnion_hil_sim::devices::canopen::{BusConfig, FrameKind, Listening, NodeConfig, NodeKind, SdoFault};
use trunnion_hil_sim::devices::{DeviceClock, Fault, Handle, SimulatedCell, TimeOrigin, canopen};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_hil_sim::replies;
use trunnion_protocol::canopen::NodeId;

#[tokio::test(flavor = "multi_thread")]
async fn without_a_can_interface_the_message_says_what_to_do_and_another_attempt_follows() {
    let text = "[[device]]\nname = \"bus\"\ndriver = \"canopen-socketcan\"\ninterface = \"can77\"\n\
                nodes = [{ id = 1, role = \"probe-1\" }]\n";
    let acquisition = read(text, Arc::new(SinceStart(Instant::now())));
    let status = state(&acquisition, |status| status.ends.iter().sum::<u64>() >= 2).await;
    match (status.state, status.last_end.clone().unwrap()) {
        // A kernel without AF_CAN.
        (DeviceState::Refused | DeviceState::Connecting, SessionEnd::Refused { address, why }) => {
            assert_eq!(address, "can77");
            assert!(why.contains("modprobe can_raw") && why.contains("canopen-slcan"), "{why}");
        }
        (DeviceState::Absent, end @ SessionEnd::Absent { .. }) => {
            assert!(end.to_string().contains("ip -br link"), "{end}");
        }
        other => panic!("{other:?}"),
    }
    acquisition.stop().await;
}

/// Not a multiple of what the thermometer shows.
const ROOM_DEGC: f64 = 21.437;

/// Three probes at 0.1 mm along x and a bar at 0.5 mm, for as long as a test lasts.
fn world() -> Arc<SimulatedCell> {
    let program = Program { start: AxisValues::default(), steps: vec![Step::Dwell { duration_s: 1e4 }] };
    Arc::new(SimulatedCell {
        deflection_mm: Box::new(|_| [0.1, 0.0, 0.0]),
        bar_mm: Box::new(|_| 0.5),
        temperature_degc: Box::new(|_| ROOM_DEGC),
        ..SimulatedCell::along(Trajectory::compile(&program).unwrap())
    })
}

/// A bus of three probes, a bar and a thermometer, its driver, and the folder of its port.
fn bus() -> (Handle, Acquisition, tempfile::TempDir) {
    bus_with(None)
}

/// The same with something that happens to one SDO answer.
fn bus_with(sdo_fault: Option<(u64, SdoFault)>) -> (Handle, Acquisition, tempfile::TempDir) {
    bus_of(|config| config.sdo_fault = sdo_fault)
}

/// As the driver has it.
const DEFAULT_SILENCE_MS: u64 = 500;

/// Three probes, a bar, and a thermometer with this number.
fn with_thermometer(number: u8) -> BusConfig {
    let clock = DeviceClock::default();
    let mut config = BusConfig::ball_bar_and_probes(clock);
    let (id, kind) = (NodeId::new(number).unwrap(), NodeKind::Thermometer { digits: 2 });
    config.nodes.push(NodeConfig { id, kind, serial: 9001, heartbeat_ms: 500, event_timer_ms: 0, clock });
    config
}

/// The same on a bus that was changed.
fn bus_of(change: impl FnOnce(&mut BusConfig)) -> (Handle, Acquisition, tempfile::TempDir) {
    bus_silent_after(DEFAULT_SILENCE_MS, change)
}

/// The same with another time without values that ends a session.
fn bus_silent_after(
    silence_ms: u64,
    change: impl FnOnce(&mut BusConfig),
) -> (Handle, Acquisition, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("can");
    let mut config = with_thermometer(9);
    change(&mut config);
    let origin = TimeOrigin(tokio::time::Instant::now());
    let handle = canopen::spawn(world(), &config, &port, origin, &[]).unwrap();
    let text = format!(
        "[[device]]\nname = \"bus\"\ndriver = \"canopen-slcan\"\nport = '{}'\nsilence_ms = {silence_ms}\nnodes = [{{ id = 1, role = \"probe-1\" }}, \
         {{ id = 2, role = \"probe-2\" }}, {{ id = 3, role = \"probe-3\" }}, {{ id = 5, role = \"bar\" }}, \
         {{ id = 9, role = \"temperature\" }}]\n",
        port.display()
    );
    (handle, read(&text, Arc::new(SinceStart(Instant::now()))), folder)
}

fn probe(message: &Message) -> Option<&ProbeReading> {
    match &message.reading {
        Reading::Probe(reading) => Some(reading),
        _ => None,
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn bus_off_ends_the_session_with_what_to_check_and_its_end_begins_another_after_a_recorded_gap() {
    let (bus, mut acquisition, _folder) = bus();
    until_message(&mut acquisition, |message| probe(message).is_some()).await;
    bus.inject(Fault::BusOff { duration_s: 2.0 }).unwrap();
    let status = state(&acquisition, |status| status.last_end.is_some()).await;
    let reported = status.last_end.unwrap().to_string();
    assert!(reported.starts_with("disconnected") && reported.contains("error passive"), "{reported}");
    assert!(reported.contains("status A6h") && reported.contains("120 Ω"), "{reported}");
    let gap = gap_of_the_next_connection(&mut acquisition, |message| probe(message).is_some()).await;
    assert!(gap.reason.contains("error passive"), "{gap:?}");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn values_out_of_range_are_no_values_and_are_taken_again_when_the_nodes_say_so() {
    let (bus, mut acquisition, _folder) = bus();
    let good = |message: &Message, channel: u16| {
        probe(message).is_some_and(|reading| reading.channel == channel && !reading.value_mm.is_nan())
    };
    until_message(&mut acquisition, |message| good(message, 3)).await;
    bus.inject(Fault::OutOfRange { duration_s: 1.0 }).unwrap();
    let mut reported = Vec::new();
    for channel in [0, 3] {
        let messages = until_message(&mut acquisition, |message| {
            probe(message).is_some_and(|reading| reading.channel == channel && reading.value_mm.is_nan())
        });
        reported.extend(messages.await.into_iter().filter_map(|message| match message.reading {
            Reading::Log(line) => Some(line.text),
            _ => None,
        }));
    }
    for words in [
        "bus.node-1 has no value: the node calls its value above the measuring range (status 6150h = 03h)",
        "bus.node-5 has no value: the node reported by an emergency that it cannot measure",
    ] {
        assert!(reported.iter().any(|line| line.starts_with(words)), "{words:?} in {reported:#?}");
    }
    for channel in [0, 3] {
        let messages = until_message(&mut acquisition, |message| good(message, channel)).await;
        let reading = messages.last().and_then(probe).unwrap();
        // The bar shows its zero of 10 mm and 0.5 mm; probe 1 lies 35.26 degrees from x.
        let expected_mm = if channel == 3 { 10.5 } else { 0.1 * (2.0_f64 / 3.0).sqrt() };
        assert!((reading.value_mm - expected_mm).abs() < 1e-4, "{reading:?}");
    }
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_temperature_is_reported_under_the_name_of_its_node_and_is_no_value_out_of_range() {
    let (bus, mut acquisition, _folder) = bus();
    let temperature = |reading: &Reading| match reading {
        Reading::Temperature(reading) => Some(reading.clone()),
        _ => None,
    };
    let first: TemperatureReading = find(&mut acquisition, temperature).await;
    // In hundredths of a degree.
    assert!(first.name == "node-9" && (first.degc - ROOM_DEGC).abs() <= 0.005 + 1e-9, "{first:?}");
    bus.inject(Fault::OutOfRange { duration_s: 0.5 }).unwrap();
    let has_value = |reading: &Reading| temperature(reading).map(|reading| reading.degc.is_finite());
    let reported = until(&mut acquisition, |reading| has_value(reading) == Some(false)).await;
    let warns = |reading: &Reading| matches!(reading, Reading::Log(line) if line.warning && line.text.contains("node-9 has no temperature"));
    assert!(reported.iter().any(warns), "{reported:?}");
    let reported = until(&mut acquisition, |reading| has_value(reading) == Some(true)).await;
    assert_eq!(reported.last().and_then(temperature).map(|reading| reading.degc), Some(first.degc));
    let gap = reported.iter().find_map(|reading| match reading {
        Reading::Gap(gap) if gap.source == "node-9" => Some(gap),
        _ => None,
    });
    assert!(gap.is_some_and(|gap| gap.lost_readings > Some(0) && gap.reason == "no temperature"), "{gap:?}");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_exchanged_for_another_kind_is_reported_and_not_retried() {
    let (bus, mut acquisition, _folder) = bus();
    until_message(&mut acquisition, |message| probe(message).is_some()).await;
    bus.inject(Fault::WrongIdentity).unwrap();
    let status = state(&acquisition, |status| status.state == DeviceState::WrongDevice).await;
    let reported = status.last_end.unwrap().to_string();
    assert!(reported.contains("I/O module") && reported.contains("CiA 404 or CiA 406"), "{reported}");
    acquisition.stop().await;
}

/// Buses at once; the others wait, for a busy computer makes devices silent.
const AT_ONCE: usize = 8;

/// Every SDO answer of the start, each late, doubled, missing and together with the next, and a node that begins again instead: the bus
/// streams in the end, in its first session, and every value is that of its node.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_sdo_answer_that_is_late_doubled_lost_or_merged_and_no_node_that_boots_disables_a_bus() {
    let of_replies = replies::CANOPEN.faults().map(|(number, fault)| (number, SdoFault::Reply(fault)));
    let cases = of_replies.chain((0..replies::CANOPEN.count).map(|number| (number, SdoFault::BootUp)));
    let room = Arc::new(tokio::sync::Semaphore::new(AT_ONCE));
    let mut running = tokio::task::JoinSet::new();
    for case in cases {
        let room = Arc::clone(&room);
        running.spawn(async move {
            let _place = room.acquire().await.unwrap();
            let (_bus, mut acquisition, _folder) = bus_with(Some(case));
            let mut read = [None; 4];
            while read.iter().any(Option::is_none) {
                let message = next(&mut acquisition).await;
                if let Some(reading) = probe(&message) {
                    read[usize::from(reading.channel)].get_or_insert(reading.value_mm);
                }
            }
            let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
            // A node that had said what it is and then begins again may be another: all are read again.
            let most_ends = u64::from(case.1 == SdoFault::BootUp);
            assert!(status.ends.iter().sum::<u64>() <= most_ends, "{case:?}: {status:?}");
            // As in the test of the range.
            let expected_mm =
                [0.1 * (2.0_f64 / 3.0).sqrt(), -0.1 / 6.0_f64.sqrt(), -0.1 / 6.0_f64.sqrt(), 10.5];
            for (value_mm, expected_mm) in read.into_iter().flatten().zip(expected_mm) {
                assert!((value_mm - expected_mm).abs() < 1e-4, "{case:?}: {read:?}");
            }
            acquisition.stop().await;
        });
    }
    running.join_all().await;
}

/// Values of each node that are read after what is disturbed.
const VALUES_AFTER: usize = 300;

/// A node whose values stop for good is silent after any time; one on a busy computer is not after this.
const LONG_SILENCE_MS: u64 = 10_000;

/// Commands of the start, heartbeats and values, each late, doubled, missing, together with the next and cut: the bus streams in the
/// end, every value is that of its node, and every SYNC is answered or its answer counted as lost, once.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_frame_that_is_late_doubled_lost_merged_or_cut_disables_a_bus_or_is_lost_in_silence() {
    let of = |kind: FrameKind, replies: &'static replies::Replies| {
        replies.faults().map(move |(number, fault)| (kind, number, fault))
    };
    let cases = of(FrameKind::Command, &replies::CAN_COMMANDS)
        .chain(of(FrameKind::Heartbeat, &replies::CAN_HEARTBEATS))
        .chain(of(FrameKind::Values, &replies::CAN_VALUES));
    let room = Arc::new(tokio::sync::Semaphore::new(AT_ONCE));
    let mut running = tokio::task::JoinSet::new();
    for case in cases {
        let room = Arc::clone(&room);
        running.spawn(async move {
            let _place = room.acquire().await.unwrap();
            // Without its start a node measures in the next session alone.
            let needs_end = case.0 != FrameKind::Values;
            let silence_ms = if needs_end { DEFAULT_SILENCE_MS } else { LONG_SILENCE_MS };
            let (bus, mut acquisition, _folder) =
                bus_silent_after(silence_ms, |config| config.frame_fault = Some(case));
            let (mut epoch, mut lost) = (0, 0);
            let mut read: [Vec<ProbeReading>; 4] = Default::default();
            while read.iter().any(|of_node| of_node.len() < VALUES_AFTER) {
                let message = next(&mut acquisition).await;
                if message.epoch != epoch {
                    (epoch, lost) = (message.epoch, 0);
                    read.iter_mut().for_each(Vec::clear);
                }
                match message.reading {
                    Reading::Probe(reading) => read[usize::from(reading.channel)].push(reading),
                    // Temperatures are not compared.
                    Reading::Gap(gap) if !gap.reason.contains("node 9 ") => {
                        lost += gap.lost_readings.unwrap_or(0);
                    }
                    _ => {}
                }
            }
            let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
            acquisition.stop().await;
            let silent = SessionEnd::Silent { who: String::new(), waited: Duration::ZERO }.kind();
            // A bus that the computer stopped for so long was silent, whatever became of its frames.
            let stopped = bus.latest() > Duration::from_millis(silence_ms / 2);
            let allowed = if stopped { status.ends[silent] } else { 0 };
            let most_ends = u64::from(needs_end) + allowed;
            let latest = bus.latest();
            assert!(status.ends.iter().sum::<u64>() <= most_ends, "{case:?}, late by {latest:?}: {status:?}");
            let wrong = SessionEnd::WrongDevice { found: String::new(), expected: String::new() }.kind();
            assert_eq!(status.ends[wrong], 0, "{case:?}: {status:?}");
            let expected_mm =
                [0.1 * (2.0_f64 / 3.0).sqrt(), -0.1 / 6.0_f64.sqrt(), -0.1 / 6.0_f64.sqrt(), 10.5];
            let mut missing = 0;
            for (of_node, expected_mm) in read.iter().zip(expected_mm) {
                for pair in of_node.windows(2) {
                    assert!(pair[0].sequence < pair[1].sequence, "{case:?}: {pair:?}");
                    missing += pair[1].sequence - pair[0].sequence - 1;
                }
                let is_off = |value: &&ProbeReading| (value.value_mm - expected_mm).abs() >= 1e-4;
                assert_eq!(of_node.iter().find(is_off), None, "{case:?}");
            }
            assert_eq!(lost, missing, "{case:?}");
        });
    }
    while let Some(ended) = running.join_next().await {
        ended.unwrap();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn behind_an_adapter_that_cannot_only_listen_nobody_is_asked() {
    for listening in [Listening::Refused, Listening::Ignored] {
        let folder = tempfile::tempdir().unwrap();
        let port = folder.path().join("can");
        let config = BusConfig { listening, ..with_thermometer(9) };
        let origin = TimeOrigin(tokio::time::Instant::now());
        let _bus = canopen::spawn(world(), &config, &port, origin, &[]).unwrap();
        let looked = look(Place::serial_port(port.to_str().unwrap()), Some("canopen-slcan")).await;
        let (driver, found) = looked.found.unwrap_or_else(|| panic!("{:?}", looked.trouble));
        let says = &found.identity;
        assert!(
            says.contains("version 1013") && says.contains("were not asked") && !says.contains("node 1"),
            "{says}"
        );
        assert!(says.contains("put `bitrate`"), "{says}");
        parse_devices("pasted", &Roles::default().table(driver, &found)).unwrap();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nodes_are_found_by_their_numbers_and_their_lines_are_a_configuration() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("can");
    // Farthest apart; one is a thermometer, and the probe 1 sends no heartbeat.
    let config = with_thermometer(127);
    let origin = TimeOrigin(tokio::time::Instant::now());
    let bus = canopen::spawn(world(), &config, &port, origin, &[]).unwrap();
    let look = || look(Place::serial_port(port.to_str().unwrap()), Some("canopen-slcan"));
    let looked = look().await;
    let (driver, found) = looked.found.unwrap_or_else(|| panic!("{:?}", looked.trouble));
    for words in
        ["version 1013", "node 1 ", "CiA 404 vendor ", " product ", "serial 1003", "node 5 ", "CiA 406"]
    {
        assert!(found.identity.contains(words), "{words}: {}", found.identity);
    }
    assert_eq!(found.identity.matches("; node ").count(), 5, "{}", found.identity);
    let lines = Roles::default().table(driver, &found);
    assert!(
        lines.contains("bitrate = 1000000") && lines.contains("{ id = 127, role = \"temperature\" }"),
        "{lines}"
    );
    parse_devices("pasted", &lines).unwrap();
    // The bus is left as it was: a session begins at once.
    let mut acquisition = read(&lines, Arc::new(SinceStart(Instant::now())));
    until_message(&mut acquisition, |message| probe(message).is_some()).await;
    acquisition.stop().await;
    bus.inject(Fault::BusOff { duration_s: 3600.0 }).unwrap();
    let looked = look().await;
    let identity = looked.found.map_or_else(String::new, |(_, found)| found.identity);
    assert!(identity.contains("no CANopen node answers"), "{identity}, {:?}", looked.trouble);
}
