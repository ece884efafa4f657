use super::*;
use crate::drivers::opcua::nodes::AxisNode;
use crate::execution::SINUMERIK;
use crate::link::Outlet;
use crate::probe;
use crate::status::DeviceStatus;
use crate::test_clock::AtZero;
use proptest::prelude::*;
use tokio::sync::watch;

fn model(link: &Link) -> Model {
    let axis = |letter: Joint| AxisNode { letter, node: NodeId::null(), unit: 1.0 };
    let nodes = Nodes {
        axes: vec![axis(Joint::X), axis(Joint::C)],
        program: Some(NodeId::null()),
        state: Some(NodeId::null()),
        block: Some(NodeId::null()),
        signal: Some(NodeId::null()),
        numbers: &SINUMERIK,
    };
    Model::new(nodes, Duration::from_millis(10), link.now())
}

fn value(value: Variant, ticks: i64) -> DataValue {
    DataValue { source_timestamp: Some(DateTime::from(ticks)), ..DataValue::value_only(value) }
}

#[test]
fn a_stamp_that_is_no_time_is_none() {
    let stamp = |ticks: i64| stamp_ns(&value(Variant::from(1.0), ticks));
    assert_eq!(stamp(TICKS_TO_1970), Some(0));
    assert_eq!(stamp(TICKS_TO_1970 + 10_000_000), Some(1_000_000_000));
    for none in [i64::MAX, DateTime::endtimes().ticks(), 1, TICKS_TO_1970 - 1] {
        assert_eq!(stamp(none), None, "{none}");
    }
}

#[test]
fn an_overflow_is_a_gap_and_what_was_never_asked_for_is_damage() {
    let (sender, mut delivered) = mpsc::channel(64);
    let (status, _) = watch::channel(DeviceStatus::default());
    let outlet = Outlet::new(0, "nc".into(), sender);
    let mut link = Link::new(0, Vec::new(), Duration::from_secs(1), Arc::new(AtZero), outlet, status);
    let mut model = model(&link);
    let overflown = |ms: i64| {
        let mut value = value(Variant::from(1.0), 133_000_000_000_000_000 + 10_000 * ms);
        value.status = Some(StatusCode::Good.set_overflow(true));
        value
    };
    for (handle, lost) in [(1, 1), (0, 1), (77, 1), (1, 2)] {
        model.take(vec![(handle, overflown(10))], &mut link);
        assert_eq!(link.counters.lost_readings, lost, "handle {handle}");
    }
    assert_eq!(link.counters.damaged, 2);
    let readings = std::iter::from_fn(|| delivered.try_recv().ok()).map(|message| message.reading);
    let gaps = readings.filter(|reading| matches!(reading, Reading::Gap(gap) if gap.from == HostTime(0)));
    assert_eq!(gaps.count(), 2);
}

fn any_variant() -> impl Strategy<Value = Variant> {
    prop_oneof![
        any::<f64>().prop_map(Variant::from),
        prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX)].prop_map(Variant::from),
        any::<i64>().prop_map(Variant::from),
        any::<u64>().prop_map(Variant::from),
        any::<bool>().prop_map(Variant::from),
        ".{0,12}".prop_map(|text: String| Variant::from(text)),
        prop::collection::vec(any::<i32>(), 0..4).prop_map(Variant::from),
        Just(Variant::Empty),
    ]
}

/// Stamps of a machine, and any.
fn any_ticks() -> impl Strategy<Value = i64> {
    let usual = 133_000_000_000_000_000..133_000_000_100_000_000_i64;
    prop_oneof![usual, any::<i64>(), Just(0), Just(1), Just(i64::MAX), Just(i64::MIN)]
}

proptest! {
    /// Whatever a server sends: handles, values, states and stamps.
    #[test]
    fn no_values_of_a_server_panic_and_no_stamp_is_before_1970(
        messages in prop::collection::vec(
            prop::collection::vec((0_u32..9, any_variant(), any_ticks(), any::<u32>(), any::<Option<u16>>()), 0..8), 1..12),
    ) {
        let mut link = probe::link(Duration::from_secs(1));
        let mut model = model(&link);
        for message in messages {
            let values = message.into_iter().map(|(handle, variant, ticks, status, picoseconds)| {
                let mut value = value(variant, ticks);
                value.source_picoseconds = picoseconds;
                value.status = (status % 2 == 0).then(|| StatusCode::from(status));
                (handle, value)
            });
            model.take(values.collect(), &mut link);
            model.nothing_changed(&mut link);
            let newest_ns = model.instants.newest_ns();
            prop_assert!(newest_ns.is_none_or(|ns| ns >= 0), "{newest_ns:?}");
        }
    }
}
