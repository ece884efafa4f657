use super::*;
use crate::link::Outlet;
use crate::status::DeviceStatus;
use crate::test_clock::AtZero;
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::{mpsc, watch};
use trunnion_core::reading::Message as Delivered;
use trunnion_protocol::canopen::cia404::{ProcessValue, Unit};
use trunnion_protocol::canopen::{
    CobId, Identity, NodeId, ObjectKey, PdoCommunication, PdoEntry, PdoMapping, Tpdo,
};

const MS: i64 = 1_000_000;

/// One probe that answers every SYNC.
struct Bench {
    nodes: Nodes,
    link: Link,
    delivered: mpsc::Receiver<Delivered>,
    id: CanId,
}

fn bench() -> Bench {
    bench_with(&[CobId::Tpdo(2, NodeId::new(1).unwrap()).can_id()])
}

/// Its value comes in each of these frames.
fn bench_with(ids: &[CanId]) -> Bench {
    bench_of(&[(1, ids)])
}

/// Probes, each with the frames in which its value comes.
fn bench_of(probes: &[(u8, &[CanId])]) -> Bench {
    let number = |id: u8| NodeId::new(id).unwrap();
    let config = |(k, (id, _)): (usize, &(u8, &[CanId]))| NodeConfig {
        id: number(*id),
        role: Role::Probe(k as u8),
        serial: None,
        bar_zero_mm: None,
    };
    let configs: Vec<NodeConfig> = probes.iter().enumerate().map(config).collect();
    let descriptions = probes.iter().map(|(id, ids)| description(number(*id), ids)).collect();
    let (sender, delivered) = mpsc::channel(64);
    let (status, _) = watch::channel(DeviceStatus::default());
    let outlet = Outlet::new(0, "bus".into(), sender);
    let link =
        Link::new(0, vec!["bus.node-1".into()], Duration::from_millis(500), Arc::new(AtZero), outlet, status);
    let nodes = Nodes::new(&configs, descriptions, 0, HostTime(0));
    Bench { nodes, link, delivered, id: probes[0].1[0] }
}

fn description(node: NodeId, ids: &[CanId]) -> NodeDescription {
    let key = ObjectKey::new(0x9130, 1);
    let tpdo = |(number, id): (u16, &CanId)| Tpdo {
        number,
        communication: PdoCommunication {
            cob_id_raw: id.raw(),
            transmission: Transmission::EverySync(1),
            event_timer_ms: 0,
        },
        mapping: PdoMapping::new(vec![PdoEntry { key, bits: 32 }]).unwrap(),
    };
    let scaling = Scaling::Process { kind: ProcessValue::Integer32, unit: Unit::MILLIMETRE, digits: 4 };
    NodeDescription {
        node,
        device_type: 404,
        identity: Identity::default(),
        name: None,
        tpdos: (2..).zip(ids).map(tpdo).collect(),
        scaling: BTreeMap::from([(key, scaling)]),
    }
}

impl Bench {
    fn may_sync(&mut self, most: u64, now: HostTime) -> bool {
        self.nodes.may_sync(most, now, &mut self.link)
    }

    /// A frame that is no reading.
    fn value_again(&mut self, arrival_ms: i64) {
        let frame = CanFrame::data_frame(self.id, &[1, 0, 0, 0]).unwrap();
        self.nodes.take(&frame, HostTime(arrival_ms * MS), &mut self.link).unwrap();
    }

    fn gaps(&mut self) -> Vec<(i64, i64, Option<u64>, String)> {
        let readings = std::iter::from_fn(|| self.delivered.try_recv().ok()).map(|message| message.reading);
        let gaps =
            readings.filter_map(|reading| if let Reading::Gap(gap) = reading { Some(gap) } else { None });
        gaps.map(|gap| (gap.from.0 / MS, gap.to.0 / MS, gap.lost_readings, gap.reason)).collect()
    }

    fn value(&mut self, arrival_ms: i64) -> ProbeReading {
        let frame = CanFrame::data_frame(self.id, &[1, 0, 0, 0]).unwrap();
        self.nodes.take(&frame, HostTime(arrival_ms * MS), &mut self.link).unwrap();
        loop {
            if let Reading::Probe(reading) = self.delivered.try_recv().unwrap().reading {
                return reading;
            }
        }
    }
}

#[test]
fn the_length_of_a_bar_counts_from_its_zero_and_its_raw_value_does_not() {
    let mut bench = bench();
    bench.link.set_bar_zero(Some((0, 10.0)));
    let reading = bench.value(1);
    assert_eq!((reading.raw, reading.value_mm), (1, 1e-4 - 10.0));
}

#[test]
fn a_lost_acknowledgement_shifts_no_value_to_the_sync_before() {
    let mut bench = bench();
    for sync in 1..=4 {
        bench.nodes.sync_written(HostTime(10 * sync * MS));
        if sync != 3 {
            bench.nodes.sync_accepted(None);
        }
        let reading = bench.value(10 * sync + 2);
        assert_eq!((reading.sequence, reading.device_ticks), (sync as u64, 10_000 * sync as u64));
    }
    assert_eq!((bench.link.counters.resyncs, bench.link.counters.lost_readings), (1, 0));
}

#[test]
fn values_are_missing_between_the_syncs_that_were_answered_however_late_the_answers_are_read() {
    let mut bench = bench();
    for sync in 1..=5 {
        bench.nodes.sync_written(HostTime(10 * sync * MS));
    }
    for sync in 1..=5 {
        bench.nodes.sync_accepted(None);
        if sync == 1 || sync == 5 {
            let frame = CanFrame::data_frame(bench.id, &[1, 0, 0, 0]).unwrap();
            bench.nodes.take(&frame, HostTime(500 * MS), &mut bench.link).unwrap();
        }
    }
    assert_eq!(bench.gaps(), [(10, 50, Some(3), "node 1 missed SYNCs".into())]);
}

#[test]
fn the_moment_of_a_value_is_the_stamp_of_its_sync_where_the_transport_has_one() {
    let mut bench = bench();
    bench.nodes.sync_written(HostTime(10 * MS));
    assert!(!bench.may_sync(1, HostTime(15 * MS)), "the first has not come back");
    bench.nodes.sync_accepted(Some(HostTime(11 * MS)));
    assert!(bench.may_sync(1, HostTime(15 * MS)));
    let reading = bench.value(13);
    assert_eq!((reading.device_ticks, reading.arrival), (11_000, HostTime(11 * MS)));
    // One that never comes back does not stop the others.
    bench.nodes.sync_written(HostTime(20 * MS));
    assert!(!bench.may_sync(1, HostTime(200 * MS)) && bench.may_sync(1, HostTime(221 * MS)));
    bench.nodes.sync_written(HostTime(221 * MS));
    // It was only late: its stamp shows that, and the next one has its own.
    bench.nodes.sync_accepted(Some(HostTime(21 * MS)));
    assert_eq!(bench.value(222).device_ticks, 21_000);
    bench.nodes.sync_accepted(Some(HostTime(222 * MS)));
    let reading = bench.value(223);
    assert_eq!((reading.sequence, reading.device_ticks), (3, 222_000));
}

#[test]
fn an_adapter_that_pauses_for_long_keeps_every_value_with_its_own_sync() {
    let mut bench = bench();
    bench.nodes.sync_written(HostTime(0));
    bench.nodes.sync_accepted(None);
    bench.value(1);
    let mut written = 1;
    for ms in 1..=1000 {
        if bench.may_sync(200, HostTime(ms * MS)) {
            bench.nodes.sync_written(HostTime(ms * MS));
            written += 1;
        }
    }
    assert_eq!(written, 201);
    for sync in 2..=written {
        bench.nodes.sync_accepted(None);
        let reading = bench.value(1001);
        assert_eq!((reading.sequence, reading.device_ticks), (sync, (sync - 1) * 1000));
    }
    assert_eq!(bench.link.counters.lost_readings, 0);
}

#[test]
fn a_node_that_answers_after_the_next_sync_is_reported_and_its_value_is_lost_once() {
    let mut bench = bench();
    for ms in [10, 11, 12] {
        bench.nodes.sync_written(HostTime(ms * MS));
        bench.nodes.sync_accepted(Some(HostTime(ms * MS)));
        if ms != 11 {
            bench.value(ms);
        }
    }
    assert_eq!(bench.link.counters.lost_readings, 1);
    let frame = CanFrame::data_frame(bench.id, &[1, 0, 0, 0]).unwrap();
    bench.nodes.take(&frame, HostTime(13 * MS), &mut bench.link).unwrap();
    let reported: Vec<Reading> =
        std::iter::from_fn(|| Some(bench.delivered.try_recv().ok()?.reading)).collect();
    let says = |piece: &str| {
        reported.iter().any(|reading| match reading {
            Reading::Gap(gap) => (gap.from.0, gap.to.0) == (12 * MS, 13 * MS) && gap.reason.contains(piece),
            Reading::Log(line) => line.text.contains(piece),
            _ => false,
        })
    };
    assert!(says("its moment is unknown") && says("longer sync_ms"), "{reported:?}");
    assert_eq!((bench.link.counters.lost_readings, bench.link.counters.resyncs), (1, 0));
    // What comes once more is the same frame.
    bench.nodes.take(&frame, HostTime(13 * MS), &mut bench.link).unwrap();
    assert_eq!((bench.link.counters.lost_readings, bench.link.counters.resyncs), (1, 1));
    assert!(bench.delivered.try_recv().is_err());
}

#[test]
fn a_late_answer_of_a_node_with_two_tpdos_is_no_repeated_frame() {
    let node = NodeId::new(1).unwrap();
    let second = CobId::Tpdo(3, node).can_id();
    let mut bench = bench_with(&[CobId::Tpdo(2, node).can_id(), second]);
    let frames = [bench.id, second].map(|id| CanFrame::data_frame(id, &[1, 0, 0, 0]).unwrap());
    for ms in [10, 11, 12] {
        bench.nodes.sync_written(HostTime(ms * MS));
        bench.nodes.sync_accepted(Some(HostTime(ms * MS)));
        for frame in frames.iter().filter(|_| ms != 11) {
            bench.nodes.take(frame, HostTime(ms * MS), &mut bench.link).unwrap();
        }
    }
    bench.nodes.take(&frames[1], HostTime(13 * MS), &mut bench.link).unwrap();
    assert_eq!((bench.link.counters.lost_readings, bench.link.counters.resyncs), (1, 0));
}

#[test]
fn a_late_answer_before_the_echo_of_the_next_sync_is_not_taken_for_an_answer_to_it() {
    let mut bench = bench();
    bench.nodes.sync_written(HostTime(10 * MS));
    bench.nodes.sync_accepted(Some(HostTime(11 * MS)));
    assert_eq!(bench.value(12).sequence, 1);
    bench.nodes.sync_written(HostTime(20 * MS));
    let frame = CanFrame::data_frame(bench.id, &[1, 0, 0, 0]).unwrap();
    bench.nodes.take(&frame, HostTime(20 * MS), &mut bench.link).unwrap();
    assert_eq!((bench.link.counters.lost_readings, bench.link.counters.resyncs), (0, 1));
    bench.nodes.sync_accepted(Some(HostTime(21 * MS)));
    let reading = bench.value(22);
    assert_eq!((reading.sequence, reading.device_ticks), (2, 21_000));
}

#[test]
fn values_that_belong_to_one_sync_or_the_one_before_are_in_a_gap_from_the_first_of_them_on() {
    let mut bench = bench();
    for ms in [10, 20, 30, 40, 50] {
        bench.nodes.sync_written(HostTime(ms * MS));
        bench.nodes.sync_accepted(Some(HostTime(ms * MS)));
        // From the second on each answer comes after the next SYNC, until the last comes in time.
        if ms != 20 {
            bench.value(ms + 2);
        }
    }
    bench.value_again(53);
    let unknown = "node 1 answered later than the next SYNC; its moment is unknown";
    assert_eq!(bench.gaps(), [(30, 53, Some(0), unknown.to_string())]);
    // Long after that a second answer is a frame that came twice.
    let resyncs = bench.link.counters.resyncs;
    bench.value_again(700);
    assert_eq!((bench.gaps(), bench.link.counters.resyncs), (vec![], resyncs + 1));
}

#[test]
fn what_a_node_did_not_answer_while_others_did_is_counted_when_the_session_ends() {
    let of = |id| [CobId::Tpdo(2, NodeId::new(id).unwrap()).can_id()];
    let (first, second) = (of(1), of(2));
    let mut bench = bench_of(&[(1, &first), (2, &second)]);
    for ms in [10, 20, 30, 40] {
        bench.nodes.sync_written(HostTime(ms * MS));
        bench.nodes.sync_accepted(Some(HostTime(ms * MS)));
        for id in [first[0], second[0]].into_iter().filter(|id| ms == 10 || *id == first[0]) {
            let frame = CanFrame::data_frame(id, &[1, 0, 0, 0]).unwrap();
            bench.nodes.take(&frame, HostTime(ms * MS), &mut bench.link).unwrap();
        }
    }
    bench.nodes.count_silent(&mut bench.link);
    assert_eq!(bench.gaps(), [(10, 40, Some(3), "node 2 missed SYNCs".to_string())]);
}

#[test]
fn a_sync_that_the_interface_lost_is_a_gap_until_the_next_one() {
    let mut bench = bench();
    bench.nodes.sync_written(HostTime(10 * MS));
    assert!(!bench.may_sync(1, HostTime(100 * MS)) && bench.may_sync(1, HostTime(220 * MS)));
    let reason = "the interface lost a SYNC, and none was sent until it was given up";
    assert_eq!(bench.gaps(), [(10, 220, None, reason.to_string())]);
}
