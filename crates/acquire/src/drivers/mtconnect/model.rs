//! The latest value of each data item of the agent.

use super::items::Items;
use crate::controller_stamp::of_measurement;
use crate::execution::MTCONNECT;
use crate::signal::signal_of;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading, TemperatureReading};
use trunnion_core::{AxisValues, HostTime, Joint, convert};
use trunnion_protocol::mtconnect::{Category, Observation, ObservedValue, StreamsDocument};

/// Longest time from a change at the controller to its arrival here, ns.
const ON_THE_WAY_NS: i64 = 30_000_000;
/// Stamps that go back, or run ahead of their arrivals, by more than this come from a clock that was set, ns.
const SET_NS: i64 = 500_000_000;

/// Items of the controller that changed since its last reading, with the stamp of the latest.
#[derive(Default)]
struct Changed<'a> {
    items: Vec<&'a str>,
    stamp_ns: i64,
}

/// Latest values.
pub(super) struct Model {
    items: Items,
    position: AxisValues<Option<f64>>,
    stamps: AxisValues<i64>,
    /// Stamp and arrival of the last axis reading that was not held.
    last_axes: Option<(i64, HostTime)>,
    sequence: u64,
    /// Observations before this number were taken: one that comes again is no second event.
    expected: u64,
    controller: (Execution, String, String),
    signal: Option<u32>,
    /// Since when an axis has no value, and why.
    absent: Option<(HostTime, Absent)>,
    /// By how much the controller's clock was set, s.
    clock_set_s: Option<f64>,
    ended_absence: Option<(HostTime, HostTime, Absent)>,
    /// The axis that has just lost its value.
    newly_absent: Option<(Joint, Absent)>,
}

/// Why an axis has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Absent {
    /// The agent has none.
    Unavailable,
    /// Its stamp is no time of a measurement.
    NoTime,
}

impl Model {
    pub(super) fn new(items: Items) -> Self {
        Self {
            items,
            position: AxisValues::default(),
            stamps: AxisValues::default(),
            last_axes: None,
            sequence: 0,
            expected: 0,
            controller: Default::default(),
            signal: None,
            absent: None,
            clock_set_s: None,
            ended_absence: None,
            newly_absent: None,
        }
    }

    /// Before `/current`: its values replace all others.
    pub(super) fn forget(&mut self) {
        self.position = AxisValues::default();
        self.expected = 0;
    }

    fn not_taken<'s>(&self, streams: &'s StreamsDocument) -> impl Iterator<Item = &'s Observation> + use<'s> {
        let expected = self.expected;
        streams.observations.iter().filter(move |observation| observation.sequence >= expected)
    }

    /// Faults and warnings among the conditions.
    pub(super) fn warnings(&self, streams: &StreamsDocument) -> Vec<String> {
        let conditions = self.not_taken(streams).filter(|observation| {
            observation.category == Category::Condition
                && matches!(observation.kind.as_str(), "Fault" | "Warning")
        });
        conditions
            .map(|observation| match &observation.value {
                ObservedValue::Text(text) => {
                    format!("{} {}: {text}", observation.kind, observation.data_item_id)
                }
                _ => format!("{} {}", observation.kind, observation.data_item_id),
            })
            .collect()
    }

    /// An axis that has lost its value, reported once when it begins.
    pub(super) fn began_absence(&mut self) -> Option<(Joint, Absent)> {
        self.newly_absent.take()
    }

    /// The time in which an axis had no value, and why, reported once when it is over.
    pub(super) fn ended_absence(&mut self) -> Option<(HostTime, HostTime, Absent)> {
        self.ended_absence.take()
    }

    /// By how much the controller's clock was set, s; reported once.
    pub(super) fn clock_was_set(&mut self) -> Option<f64> {
        self.clock_set_s.take()
    }

    /// Readings of a document, in order of sequence: one axis reading for each stamp.
    pub(super) fn take(&mut self, streams: &StreamsDocument, arrival: HostTime) -> Vec<Reading> {
        let mut observations: Vec<&Observation> = self.not_taken(streams).collect();
        self.expected = self.expected.max(streams.next_sequence);
        observations.sort_by_key(|observation| observation.sequence);
        let mut readings = Vec::new();
        let mut pending: Option<i64> = None;
        let mut changed = Changed::default();
        for observation in observations {
            if let Some(letter) = self.axis_of(observation) {
                if let Some(stamp) = pending.filter(|&stamp| stamp != observation.timestamp_ns) {
                    readings.extend(self.axes(stamp, arrival, false));
                }
                pending = Some(observation.timestamp_ns);
                self.set_axis(letter, observation, arrival);
            } else if self.items.is_of_controller(&observation.data_item_id) {
                // A document may hold the end of one program and the beginning of the next.
                if changed.items.contains(&observation.data_item_id.as_str()) {
                    readings.push(self.controller(changed.stamp_ns, arrival));
                    changed.items.clear();
                }
                changed.items.push(&observation.data_item_id);
                changed.stamp_ns = of_measurement(observation.timestamp_ns).unwrap_or_default();
                self.set_controller(observation);
            } else if let Some(name) = self.items.temperatures.get(&observation.data_item_id) {
                let degc = number(&observation.value).unwrap_or(f64::NAN);
                readings.push(Reading::Temperature(TemperatureReading { name: name.clone(), degc, arrival }));
            }
        }
        match pending {
            Some(stamp) => readings.extend(self.axes(stamp, arrival, false)),
            None => readings.extend(self.held(arrival)),
        }
        if !changed.items.is_empty() {
            readings.push(self.controller(changed.stamp_ns, arrival));
        }
        readings
    }

    fn controller(&self, stamp_ns: i64, arrival: HostTime) -> Reading {
        let (execution, program, block) = self.controller.clone();
        let signal = self.signal;
        Reading::Controller(ControllerReading { execution, program, block, signal, stamp_ns, arrival })
    }

    fn axis_of(&self, observation: &Observation) -> Option<Joint> {
        let is_it = |id: &Option<String>| id.as_ref() == Some(&observation.data_item_id);
        Joint::ISO.into_iter().find(|&letter| is_it(&self.items.axes[letter]))
    }

    fn set_axis(&mut self, letter: Joint, observation: &Observation, arrival: HostTime) {
        let (value, why) = match (number(&observation.value), of_measurement(observation.timestamp_ns)) {
            (Some(_), None) => (None, Absent::NoTime),
            (value, _) => (value, Absent::Unavailable),
        };
        self.position[letter] = value.map(|v| if letter.is_rotary() { convert::rad_from_deg(v) } else { v });
        self.stamps[letter] = observation.timestamp_ns;
        self.sequence = observation.sequence;
        if value.is_none() && self.absent.is_none() {
            (self.absent, self.newly_absent) = (Some((arrival, why)), Some((letter, why)));
        }
    }

    fn set_controller(&mut self, observation: &Observation) {
        let id = Some(&observation.data_item_id);
        let text = match &observation.value {
            ObservedValue::Text(text) => text.clone(),
            ObservedValue::Number(number) => number.to_string(),
            ObservedValue::Unavailable => String::new(),
        };
        let (execution, program, block) = &mut self.controller;
        if id == self.items.execution.as_ref() {
            *execution = MTCONNECT.execution(&text);
        } else if id == self.items.program.as_ref() {
            *program = text;
        } else if id == self.items.block.as_ref() {
            *block = text;
        } else if id == self.items.signal.as_ref() {
            self.signal = (!text.is_empty()).then(|| signal(&text));
        }
    }

    /// A reading of all axes at a stamp; none while one that the controller has is unavailable.
    fn axes(&mut self, stamp_ns: i64, arrival: HostTime, held: bool) -> Option<Reading> {
        let present = AxisValues::from_fn(|letter| self.items.axes[letter].is_some());
        if Joint::ISO.iter().any(|&letter| present[letter] && self.position[letter].is_none()) {
            return None;
        }
        if let Some((since, why)) = self.absent.take() {
            self.ended_absence = Some((since, arrival, why));
        }
        // Equal stamps come in order; a stamp behind the last one would send the clock back.
        if let Some((last, at)) = self.last_axes.filter(|_| !held) {
            let step_ns = stamp_ns - last;
            if step_ns < -SET_NS || step_ns - (arrival.0 - at.0) > SET_NS {
                self.clock_set_s = Some((step_ns - (arrival.0 - at.0)) as f64 * 1e-9);
            } else if step_ns <= 0 {
                return None;
            }
        }
        if !held {
            self.last_axes = Some((stamp_ns, arrival));
        }
        let position = AxisValues::from_fn(|letter| self.position[letter].unwrap_or(0.0));
        let reading =
            AxisReading { stamp_ns, arrival, position, present, sequence: self.sequence, held, skew_ns: 0 };
        Some(Reading::Axes(reading))
    }

    /// Nothing has changed: the last positions hold, as long after their stamp as after their arrival, less what a
    /// change under way may take.
    fn held(&mut self, arrival: HostTime) -> Option<Reading> {
        let (stamp_ns, at) = self.last_axes?;
        let later_ns = arrival.0 - at.0 - ON_THE_WAY_NS;
        if later_ns <= 0 {
            return None;
        }
        self.axes(stamp_ns + later_ns, arrival, true)
    }
}

fn number(value: &ObservedValue) -> Option<f64> {
    match value {
        ObservedValue::Number(number) => Some(*number),
        ObservedValue::Unavailable | ObservedValue::Text(_) => None,
    }
}

/// Its number; 1 for a word that means *on* in the vocabularies of the standard (`ON`, `ACTIVE`, `CLOSED`) and of adapters, else 0.
fn signal(text: &str) -> u32 {
    let is_on = || ["ON", "ACTIVE", "CLOSED", "TRUE", "YES", "HIGH"].contains(&text.to_uppercase().as_str());
    text.parse().map_or_else(|_| u32::from(is_on()), signal_of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    const IDS: [&str; 8] = ["x", "c", "execution", "program", "block", "signal", "room", "other"];

    fn model() -> Model {
        let mut axes = AxisValues::default();
        (axes[Joint::X], axes[Joint::C]) = (Some("x".into()), Some("c".into()));
        let [execution, program, block, signal] =
            ["execution", "program", "block", "signal"].map(|id| Some(id.to_owned()));
        let temperatures = BTreeMap::from([("room".into(), "room".into())]);
        Model::new(Items { axes, execution, program, block, signal, temperatures })
    }

    fn observation(id: &str, value: ObservedValue, timestamp_ns: i64, sequence: u64) -> Observation {
        Observation {
            data_item_id: id.into(),
            device: String::new(),
            component: String::new(),
            component_id: String::new(),
            category: Category::Sample,
            kind: "Position".into(),
            sub_type: None,
            sequence,
            timestamp_ns,
            value,
        }
    }

    fn taken(model: &mut Model, observations: Vec<Observation>, arrival_ns: i64) -> Vec<Reading> {
        model.take(&StreamsDocument { observations, ..StreamsDocument::default() }, HostTime(arrival_ns))
    }

    #[test]
    fn positions_with_a_stamp_that_is_no_time_are_no_positions() {
        let of = |stamp_ns: i64| {
            ["x", "c"].map(|id| observation(id, ObservedValue::Number(1.0), stamp_ns, 1)).to_vec()
        };
        let mut model = model();
        let reported = [Some((Joint::X, Absent::NoTime)), None, None];
        for (none, reported) in [-1, i64::MIN, i64::MAX].into_iter().zip(reported) {
            assert!(taken(&mut model, of(none), 1).is_empty(), "{none}");
            assert_eq!(model.began_absence(), reported);
            assert!(model.absent.is_some());
        }
        let readings = taken(&mut model, of(1_700_000_000_000_000_000), 2);
        assert!(matches!(readings[..], [Reading::Axes(_)]), "{readings:?}");
        assert_eq!(model.ended_absence(), Some((HostTime(1), HostTime(2), Absent::NoTime)));
        let gone = vec![observation("x", ObservedValue::Unavailable, 1_700_000_001_000_000_000, 2)];
        assert!(taken(&mut model, gone, 3).is_empty());
        assert_eq!(model.began_absence(), Some((Joint::X, Absent::Unavailable)));
    }

    #[test]
    fn a_document_that_comes_twice_is_one_event() {
        let mut model = model();
        let program = |word: &str, sequence: u64| {
            observation("execution", ObservedValue::Text(word.into()), 1_700_000_000_000_000_000, sequence)
        };
        let document = StreamsDocument {
            observations: vec![program("READY", 7), program("ACTIVE", 8), program("READY", 9)],
            next_sequence: 10,
            ..StreamsDocument::default()
        };
        let controllers = |readings: Vec<Reading>| {
            readings.iter().filter(|reading| matches!(reading, Reading::Controller(_))).count()
        };
        assert_eq!(controllers(model.take(&document, HostTime(1))), 3);
        assert_eq!(controllers(model.take(&document, HostTime(2))), 0);
        model.forget();
        assert_eq!(controllers(model.take(&document, HostTime(3))), 3, "/current may begin again");
    }

    fn any_stamp() -> impl Strategy<Value = i64> {
        let usual = 1_700_000_000_000_000_000..1_700_000_001_000_000_000_i64;
        prop_oneof![usual, any::<i64>(), Just(i64::MIN), Just(i64::MAX), Just(0)]
    }

    fn any_value() -> impl Strategy<Value = ObservedValue> {
        prop_oneof![
            prop_oneof![any::<f64>(), Just(f64::NAN), Just(f64::MAX)].prop_map(ObservedValue::Number),
            ".{0,12}".prop_map(ObservedValue::Text),
            Just(ObservedValue::Unavailable),
        ]
    }

    proptest! {
        /// Whatever an agent sends, in whatever order.
        #[test]
        fn no_observations_panic_and_stamps_are_times(
            documents in prop::collection::vec(
                (prop::collection::vec((0..IDS.len(), any_value(), any_stamp(), any::<u64>()), 0..10), 0_i64..10_000_000_000), 1..10),
        ) {
            let (mut model, mut arrival_ns) = (model(), 0);
            for (observations, later_ns) in documents {
                arrival_ns += later_ns;
                let observations = observations.into_iter()
                    .map(|(id, value, stamp_ns, sequence)| observation(IDS[id], value, stamp_ns, sequence));
                for reading in taken(&mut model, observations.collect(), arrival_ns) {
                    match reading {
                        Reading::Axes(axes) => prop_assert!(axes.stamp_ns >= 0, "{axes:?}"),
                        Reading::Controller(controller) => prop_assert!(controller.stamp_ns >= 0, "{controller:?}"),
                        _ => {}
                    }
                }
            }
        }
    }
}
