//! The rules of Sparkplug B sessions as properties: a host that follows the messages knows the view, whatever happens.

use proptest::prelude::*;
use prost::Message as _;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trunnion_service::board::Board;
use trunnion_service::config::Config;
use trunnion_service::mqtt::sparkplug::{
    Message, Metric, Metrics, Payload, Session, Value, View, WireMetric, WireValue,
};

const REBIRTH: &str = "Node Control/Rebirth";

/// A host: what it believes of one node, by the rules of the specification alone.
#[derive(Default)]
struct Host {
    seq: u64,
    bd_seq: u64,
    node: Metrics,
    devices: BTreeMap<String, Metrics>,
}

impl Host {
    /// Takes a message, and refuses what breaks a rule.
    fn take(&mut self, message: &Message) {
        let words: Vec<&str> = message.topic.split('/').collect();
        assert_eq!((words[0], words[1], words[3]), ("spBv1.0", "plant", "cell"));
        let payload = Payload::decode(message.payload.as_slice()).expect("a payload");
        let (kind, device) = (words[2], words.get(4).map(|name| (*name).to_owned()));
        assert_eq!(kind.starts_with('D'), device.is_some());
        assert!(payload.timestamp.is_some());
        assert_eq!(message.qos as u8, 0);
        let seq = payload.seq.expect("every message but the death of a node has a number");
        let expected = if kind == "NBIRTH" { 0 } else { (self.seq + 1) % 256 };
        assert_eq!(seq, expected, "{kind}");
        self.seq = seq;
        let is_birth = kind.ends_with("BIRTH");
        match (kind, device) {
            ("NBIRTH", _) => {
                *self = Self { node: named(&payload), bd_seq: self.born(&payload), ..Self::default() }
            }
            ("NDATA", _) => follow(&mut self.node, &payload),
            ("DBIRTH", Some(name)) => {
                self.devices.insert(name, named(&payload));
            }
            ("DDATA", Some(name)) => follow(self.devices.get_mut(&name).expect("it is born"), &payload),
            ("DDEATH", Some(name)) => {
                assert!(payload.metrics.is_empty());
                self.devices.remove(&name).expect("it was born");
            }
            other => panic!("{other:?}"),
        }
        assert!(payload.metrics.iter().all(|metric| metric.datatype.is_some() == is_birth));
    }

    fn born(&self, payload: &Payload) -> u64 {
        let of = |name: &str| payload.metrics.iter().find(|metric| metric.name.as_deref() == Some(name));
        assert_eq!(of(REBIRTH).and_then(|metric| metric.value.clone()), Some(WireValue::Boolean(false)));
        match of("bdSeq").and_then(|metric| metric.value.clone()) {
            Some(WireValue::Long(number)) => number,
            other => panic!("{other:?}"),
        }
    }

    /// What the node should be believed to be: a metric that is gone may stay without a value.
    fn believes(&self, view: &View) {
        agrees(&self.node, &view.node);
        let names = |devices: &BTreeMap<String, Metrics>| devices.keys().cloned().collect::<BTreeSet<_>>();
        assert_eq!(names(&self.devices), names(&view.devices));
        for (name, metrics) in &view.devices {
            agrees(&self.devices[name], metrics);
        }
    }
}

fn agrees(believed: &Metrics, metrics: &Metrics) {
    for (name, metric) in metrics {
        assert_eq!(believed.get(name), Some(metric), "{name}");
    }
    for (name, metric) in believed.iter().filter(|(name, _)| !metrics.contains_key(*name)) {
        assert_eq!(metric.value, metric.value.none(), "{name} is gone");
    }
}

fn value(datatype: u32, value: Option<WireValue>) -> Value {
    match (datatype, value) {
        (4, None) => Value::Count(None),
        (4, Some(WireValue::Long(bits))) => Value::Count(Some(bits.cast_signed())),
        (10, None) => Value::Number(None),
        (10, Some(WireValue::Double(number))) => Value::Number(Some(number)),
        (11, None) => Value::Flag(None),
        (11, Some(WireValue::Boolean(flag))) => Value::Flag(Some(flag)),
        (12, None) => Value::Text(None),
        (12, Some(WireValue::Text(text))) => Value::Text(Some(text)),
        other => panic!("{other:?} does not go together"),
    }
}

/// The metrics of a birth, without those that every node has.
fn named(payload: &Payload) -> Metrics {
    let mut metrics = Metrics::new();
    for metric in payload.metrics.iter().cloned() {
        let name = metric.name.expect("a name");
        if name == "bdSeq" || name == REBIRTH {
            continue;
        }
        let unit = metric.properties.map_or_else(String::new, |properties| {
            assert_eq!(properties.keys, ["engUnit"]);
            properties.values[0].text.clone().expect("a unit")
        });
        assert_eq!(metric.value.is_none(), metric.is_null == Some(true));
        let value = value(metric.datatype.expect("a birth says the type"), metric.value);
        assert!(metrics.insert(name, Metric { value, unit }).is_none(), "a name of its own");
    }
    metrics
}

fn follow(known: &mut Metrics, payload: &Payload) {
    assert!(!payload.metrics.is_empty(), "nothing is sent without news");
    for metric in payload.metrics.iter().cloned() {
        let before = known.get_mut(metric.name.as_deref().unwrap()).expect("the birth named it");
        let datatype = match before.value {
            Value::Count(_) => 4,
            Value::Number(_) => 10,
            Value::Flag(_) => 11,
            Value::Text(_) => 12,
        };
        let now = value(datatype, metric.value);
        assert_ne!(before.value, now, "it changed");
        before.value = now;
    }
}

/// What may happen to a node.
#[derive(Clone, Debug)]
enum Step {
    Shows(View),
    Connects,
    IsAskedForRebirth,
}

fn values() -> impl Strategy<Value = Value> {
    prop_oneof![
        proptest::option::of("[a-c]?").prop_map(Value::Text),
        proptest::option::of(-2.0..2.0).prop_map(Value::Number),
        proptest::option::of(-2_i64..2).prop_map(Value::Count),
        proptest::option::of(any::<bool>()).prop_map(Value::Flag),
    ]
}

fn metrics() -> impl Strategy<Value = Metrics> {
    let metric = (values(), "(mm)?").prop_map(|(value, unit)| Metric { value, unit });
    proptest::collection::btree_map("[a-d]", metric, 0..4)
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let view = (metrics(), proptest::collection::btree_map("[x-z]", metrics(), 0..3))
        .prop_map(|(node, devices)| View { node, devices });
    let step = prop_oneof![
        6 => view.prop_map(Step::Shows),
        1 => Just(Step::Connects),
        1 => Just(Step::IsAskedForRebirth),
    ];
    proptest::collection::vec(step, 1..40)
}

proptest! {
    #[test]
    fn a_host_that_follows_the_messages_knows_the_view(steps in steps()) {
        let (mut session, mut host, mut view) = (Session::new("plant", "cell"), Host::default(), View::default());
        let mut death = session.next_death();
        let (mut connections, mut is_to_be_born) = (0, true);
        for step in steps {
            is_to_be_born |= !matches!(step, Step::Shows(_));
            match step {
                Step::Shows(now) => view = now,
                Step::Connects => {
                    death = session.next_death();
                    connections += 1;
                    session.bear_again();
                }
                Step::IsAskedForRebirth => session.bear_again(),
            }
            let messages = session.news(view.clone(), 1_000);
            messages.iter().for_each(|message| host.take(message));
            host.believes(&view);
            if std::mem::take(&mut is_to_be_born) {
                prop_assert!(messages[0].topic.contains("NBIRTH"));
            }
            // The death that the broker holds is that of this birth.
            prop_assert_eq!(&session.death(), &death);
            prop_assert_eq!(host.bd_seq, connections % 256);
            prop_assert!(session.news(view.clone(), 2_000).is_empty(), "nothing is sent twice");
        }
    }
}

#[test]
fn a_death_has_the_number_of_its_birth_and_none_of_its_own() {
    let mut session = Session::new("plant", "cell");
    let numbers = (0..300).map(|_| {
        let death = session.next_death();
        assert_eq!((death.topic.as_str(), death.qos as u8), ("spBv1.0/plant/NDEATH/cell", 1));
        let payload = Payload::decode(death.payload.as_slice()).unwrap();
        assert_eq!((payload.seq, payload.metrics.len()), (None, 1));
        assert_eq!(payload.metrics[0].name.as_deref(), Some("bdSeq"));
        payload.metrics[0].value.clone()
    });
    let expected: Vec<_> = (0..300).map(|number| Some(WireValue::Long(number % 256))).collect();
    assert_eq!(numbers.collect::<Vec<_>>(), expected);
}

#[test]
fn only_a_rebirth_that_is_true_is_one() {
    let session = Session::new("plant", "cell");
    let command = |name: &str, value: WireValue| {
        let metric = WireMetric { name: Some(name.into()), value: Some(value), ..Default::default() };
        session.asks_for_rebirth(&Payload { metrics: vec![metric], ..Payload::default() }.encode_to_vec())
    };
    assert!(command(REBIRTH, WireValue::Boolean(true)));
    assert!(!command(REBIRTH, WireValue::Boolean(false)));
    assert!(!command("Node Control/Reboot", WireValue::Boolean(true)));
    assert!(!command(REBIRTH, WireValue::Long(1)));
    assert!(!session.asks_for_rebirth(b"\xff\xff\xff"));
    assert_eq!(session.commands(), "spBv1.0/plant/NCMD/cell");
}

#[test]
fn only_devices_that_are_connected_are_shown_and_each_with_its_own_channels() {
    let board = Board::default();
    let device = |state: &str| {
        json!({ "state": state, "identity": "", "connections": 1, "ends": 0,
        "lost_messages": 0, "last_end": null })
    };
    board.set(
        "status",
        &json!({ "state": "online", "reason": null, "chosen": null, "cycle": null, "health": null,
        "devices": { "a": device("Streaming"), "b": device("Stuck"), "c": device("Silent") } }),
    );
    let probe = |name: &str, value: f64| {
        json!({ "name": name, "device": name, "role": "", "value_mm": value,
        "range_mm": null, "centre_mm": null, "zone": "unknown", "say": "" })
    };
    board.set(
        "live",
        &json!({ "format": "trunnion-live/1", "at": "", "ball_offset_mm": null, "say": "",
        "probes": [probe("a", 1.0), probe("b", 2.0), probe("c", 3.0)], "devices": [], "cycle": null,
        "axes": [{ "name": "X", "device": "b", "value": -4.5, "unit": "mm" }],
        "temperatures": [{ "name": "room", "device": "a", "value_degc": null }] }),
    );
    let view = View::of(&board);
    let names = |device: &str| {
        let metrics = view.devices[device].iter().filter(|(name, _)| name.contains('/'));
        metrics
            .map(|(name, metric)| (name.as_str(), metric.value.clone(), metric.unit.as_str()))
            .collect::<Vec<_>>()
    };
    assert_eq!(view.devices.keys().collect::<Vec<_>>(), ["a", "b"]);
    let (number, text) = (|value| Value::Number(Some(value)), || Value::Text(Some(String::new())));
    assert_eq!(
        names("a"),
        [
            ("Probes/a/Remark", text(), ""),
            ("Probes/a/Value", number(1.0), "mm"),
            ("Temperatures/room", Value::Number(None), "degC"),
        ]
    );
    assert_eq!(
        names("b"),
        [
            ("Axes/X", number(-4.5), "mm"),
            ("Probes/b/Remark", text(), ""),
            ("Probes/b/Value", number(2.0), "mm"),
        ]
    );
}

#[test]
fn a_name_that_would_change_a_topic_is_refused() {
    let example = include_str!("../../../../config/trunnion.toml");
    let with = |table: &str| {
        let text = example.replace("[mqtt]\n", &format!("[mqtt]\nsparkplug = {{ {table} }}\n"));
        Config::parse(Path::new("trunnion.toml"), &text)
    };
    let node = with("group = \"plant\"").unwrap().mqtt.unwrap().sparkplug.unwrap();
    assert_eq!((node.group.as_str(), node.node.as_str()), ("plant", "machine-1"));
    let node = with("group = \"plant\", node = \"cell 4\"").unwrap().mqtt.unwrap().sparkplug.unwrap();
    assert_eq!(node.node, "cell 4");
    for (table, word) in [
        ("group = \"a/b\"", "group"),
        ("group = \"a\", node = \"#\"", "node"),
        ("node = \"a\"", "group"),
        ("group = \"a\", host = \"b\"", "host"),
    ] {
        let problems = with(table).unwrap_err().to_string();
        assert!(problems.contains("mqtt.sparkplug") && problems.contains(word), "{problems}");
    }
}
