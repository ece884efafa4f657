//! Reading nodes at start, against an SDO server with the objects of the reference nodes (python canopen peer) and
//! against variants of them.

use std::collections::BTreeMap;
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::cia404::{InputStatus, Quantity};
use trunnion_protocol::canopen::*;

struct Objects(BTreeMap<ObjectKey, Vec<u8>>);

impl ObjectDictionary for Objects {
    fn read(&mut self, key: ObjectKey) -> Result<Vec<u8>, AbortCode> {
        self.0.get(&key).cloned().ok_or(AbortCode::NO_OBJECT)
    }

    fn write(&mut self, _: ObjectKey, _: &[u8]) -> Result<(), AbortCode> {
        panic!("reading a node must not write to it")
    }
}

fn objects(list: &[(u16, u8, u32, usize)]) -> Objects {
    let bytes = |value: u32, length: usize| value.to_le_bytes()[..length].to_vec();
    Objects(
        list.iter()
            .map(|&(index, sub, value, length)| (ObjectKey::new(index, sub), bytes(value, length)))
            .collect(),
    )
}

/// Objects as served by the peer: 9130h in 0.1 µm and the status after every SYNC.
fn probe() -> Objects {
    let mut objects = objects(&[
        (0x1000, 0, 0x0002_0194, 4),
        (0x1018, 0, 4, 1),
        (0x1018, 1, 0x2D, 4),
        (0x1018, 2, 0x0194, 4),
        (0x1018, 3, 0x0001_0000, 4),
        (0x1018, 4, 1001, 4),
        (0x1800, 1, 0x181, 4),
        (0x1800, 2, 1, 1),
        (0x1800, 5, 0, 2),
        (0x1A00, 0, 2, 1),
        (0x1A00, 1, 0x9130_0120, 4),
        (0x1A00, 2, 0x6150_0108, 4),
        (0x6131, 1, 0xFD01_0000, 4),
        (0x6132, 1, 4, 1),
    ]);
    objects.0.insert(ObjectKey::new(0x1008, 0), b"R-test probe 1 (CiA 404)".to_vec());
    objects
}

fn encoder() -> Objects {
    objects(&[
        (0x1000, 0, 0x0008_0196, 4),
        (0x1018, 0, 1, 1),
        (0x1018, 1, 0x2D, 4),
        (0x1800, 1, 0x8000_0181, 4),
        (0x1801, 1, 0x281, 4),
        (0x1801, 2, 254, 1),
        (0x1801, 5, 10, 2),
        (0x1A01, 0, 2, 1),
        (0x1A01, 1, 0x6004_0020, 4),
        (0x1A01, 2, 0x6030_0110, 4),
        (0x6501, 0, 100, 4),
        (0x6005, 2, 10, 4),
    ])
}

fn read(mut objects: Objects) -> Result<NodeDescription, StartupError> {
    let node = NodeId::new(1).expect("1 is in 1..=127");
    let mut server = SdoServer::new(node);
    let (mut startup, mut request) = NodeStartup::new(node);
    for _ in 0..500 {
        let answer = server.on_frame(&request, &mut objects).expect("requests to this node are answered");
        match startup.on_frame(&answer) {
            StartupProgress::Send(next) => request = next,
            StartupProgress::Done(description) => return Ok(*description),
            StartupProgress::Failed { error, .. } => return Err(error),
            StartupProgress::NotMine => panic!("the answer is for this node"),
        }
    }
    panic!("the procedure does not end")
}

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).expect("test frames fit the bus")
}

#[test]
fn a_probe_reports_what_its_tpdo_means() {
    let description = read(probe()).unwrap();
    assert_eq!(description.profile(), Profile::MeasuringDevice);
    assert_eq!(description.name.as_deref(), Some("R-test probe 1 (CiA 404)"));
    assert_eq!(description.identity.serial, Some(1001));
    assert_eq!(description.synchronous_tpdos().count(), 1);
    // Recorded from the peer: t18153300000000, 51 counts of 0.1 µm, status good.
    let readings = description.decode(&frame(0x181, &[0x33, 0, 0, 0, 0])).unwrap().unwrap();
    let Value::Quantity(Quantity::LengthMm(mm)) = readings[0].value else { panic!("{readings:?}") };
    assert!((mm - 0.0051).abs() < 1e-12);
    assert_eq!(readings[1].value, Value::Status(InputStatus(0)));
    assert_eq!(description.decode(&frame(0x182, &[0; 5])), None);
    let short = description.decode(&frame(0x181, &[0x33])).unwrap().unwrap_err();
    assert_eq!(short.source, PdoError::ShortFrame { needed: 5, got: 1 });
    let overload = description.decode(&frame(0x181, &[0, 0, 0, 0x80, 3])).unwrap().unwrap();
    assert_eq!(overload[0].value, Value::NoValue);
}

#[test]
fn an_encoder_is_read_by_its_own_steps_and_a_switched_off_tpdo_is_left_out() {
    let description = read(encoder()).unwrap();
    assert_eq!(description.profile(), Profile::Encoder);
    assert_eq!(description.tpdos.iter().map(|tpdo| tpdo.number).collect::<Vec<_>>(), [2]);
    assert_eq!(description.tpdos[0].communication.event_timer_ms, 10);
    let readings = description.decode(&frame(0x281, &[0x40, 0x42, 0x0F, 0, 0xFE, 0xFF])).unwrap().unwrap();
    let Value::Quantity(Quantity::LengthMm(mm)) = readings[0].value else { panic!("{readings:?}") };
    assert!((mm - 100.0).abs() < 1e-9);
    assert_eq!(readings[1].value, Value::SpeedMmPerS(-0.2));
    assert_eq!((description.name, description.identity.product), (None, None));
}

#[test]
fn a_rotary_encoder_is_given_raw() {
    let mut objects = encoder();
    objects.0.insert(ObjectKey::new(0x1000, 0), 0x0002_0196u32.to_le_bytes().to_vec());
    let readings = read(objects).unwrap().decode(&frame(0x281, &[1, 0, 0, 0, 0, 0])).unwrap().unwrap();
    assert_eq!(readings[0].value, Value::Raw);
    assert_eq!(readings[0].raw, RawBits::new(1, 32));
}

#[test]
fn a_unit_the_node_does_not_report_leaves_the_value_raw() {
    let mut objects = probe();
    objects.0.remove(&ObjectKey::new(0x6131, 1));
    let readings = read(objects).unwrap().decode(&frame(0x181, &[0x33, 0, 0, 0, 0])).unwrap().unwrap();
    assert_eq!(readings[0].value, Value::Raw);
}

#[test]
fn a_node_that_lacks_what_it_must_have_is_refused() {
    let node = NodeId::new(1).unwrap();
    let check = |key: ObjectKey| {
        let mut objects = probe();
        objects.0.remove(&key);
        assert_eq!(read(objects), Err(StartupError::Missing { node, key, reason: AbortCode::NO_OBJECT }));
    };
    check(ObjectKey::new(0x1000, 0));
    check(ObjectKey::new(0x1018, 1));
    check(ObjectKey::new(0x1800, 2));
    check(ObjectKey::new(0x1A00, 0));
    check(ObjectKey::new(0x1A00, 2));
    let mut objects = probe();
    objects.0.insert(ObjectKey::new(0x1A00, 2), 0x6150_0140u32.to_le_bytes().to_vec());
    let source = PdoError::TooLong(96);
    assert_eq!(read(objects), Err(StartupError::Mapping { node, number: 1, source }));
}

#[test]
fn a_node_that_claims_too_much_is_read_to_an_end() {
    let mut objects = probe();
    objects.0.insert(ObjectKey::new(0x1A00, 0), vec![0xFF]);
    objects.0.insert(ObjectKey::new(0x1018, 0), vec![0xFF]);
    assert!(matches!(read(objects), Err(StartupError::Missing { .. })));
}
