//! What the node and its devices show: the figures of the JSON topics, under names for hosts.

use crate::board::Board;
use crate::plant::{PlantView, topic};
use std::collections::BTreeMap;
use trunnion::results::{AlarmsNow, CycleProgress, DeviceNow, Live, Published, ReadyNow, StorageNow};

/// Metrics by name.
pub type Metrics = BTreeMap<String, Metric>;

/// A value with its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Its value.
    pub value: Value,
    /// Its unit; empty without one.
    pub unit: String,
}

/// A value of a type; none where it is not known.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// String.
    Text(Option<String>),
    /// Double, finite.
    Number(Option<f64>),
    /// Int64.
    Count(Option<i64>),
    /// Boolean.
    Flag(Option<bool>),
}

impl Value {
    /// The same type without a value.
    pub fn none(&self) -> Self {
        match self {
            Self::Text(_) => Self::Text(None),
            Self::Number(_) => Self::Number(None),
            Self::Count(_) => Self::Count(None),
            Self::Flag(_) => Self::Flag(None),
        }
    }
}

/// Everything that hosts see.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Of the node.
    pub node: Metrics,
    /// Of the devices that are connected.
    pub devices: BTreeMap<String, Metrics>,
}

impl View {
    /// As the board has it now.
    pub fn of(board: &Board) -> Self {
        let plant = PlantView::of(board);
        let live = topic::<Live>(board, "live").unwrap_or_default();
        let devices = plant.status.devices.iter().filter(|(_, device)| is_connected(device));
        let devices = devices.map(|(name, now)| (name.clone(), device(name, now, &live))).collect();
        Self { node: node(&plant, board), devices }
    }
}

/// Readings arrive; stuck ones too.
fn is_connected(device: &DeviceNow) -> bool {
    matches!(device.state.as_str(), "Streaming" | "Stuck")
}

fn node(plant: &PlantView, board: &Board) -> Metrics {
    let mut list = List::default();
    let now = plant.status.cycle.clone().unwrap_or_default();
    let cycle: CycleProgress = topic(board, CycleProgress::TOPIC).unwrap_or_default();
    list.text("Version", Some(env!("CARGO_PKG_VERSION").into()));
    list.text("Cycle/State", Some(now.state.as_str().into()));
    list.text("Cycle/Run", now.run);
    list.text("Cycle/Name", cycle.cycle);
    list.text("Cycle/Program", cycle.program);
    list.text("Cycle/Why", cycle.why);
    list.count("Cycle/Done", cycle.done.and_then(|done| done.try_into().ok()));
    list.count("Cycle/Total", cycle.total.and_then(|total| total.try_into().ok()));
    list.number("Cycle/Time left", cycle.seconds_left, "s");
    let ready: Option<ReadyNow> = topic(board, ReadyNow::TOPIC);
    list.flag("Ready/State", ready.as_ref().map(|ready| ready.ready));
    list.text("Ready/Why", Some(ready.map_or_else(String::new, |ready| ready.why.join("; "))));
    let health = plant.status.health.clone().unwrap_or_default();
    list.text("Health/State", Some(health.state.as_str().into()));
    list.text("Health/Why", Some(plant.why()));
    for (name, part) in health.parts {
        list.text(&format!("Health/{name}/State"), Some(part.state.as_str().into()));
        list.text(&format!("Health/{name}/Why"), Some(part.why));
    }
    let storage: Option<StorageNow> = topic(board, StorageNow::TOPIC);
    let of_storage = storage.as_ref();
    list.text("Storage/State", of_storage.map(|storage| storage.state.as_str().into()));
    list.text("Storage/Why", of_storage.and_then(|storage| storage.why.clone()));
    list.number("Storage/Free", of_storage.and_then(|storage| storage.free_mb), "MB");
    list.count("Storage/Lost samples", of_storage.and_then(|storage| storage.lost_samples.try_into().ok()));
    let alarms: Option<AlarmsNow> = topic(board, AlarmsNow::TOPIC);
    let names = |now: &AlarmsNow| now.alarms.iter().map(|alarm| alarm.name.clone()).collect::<Vec<_>>();
    list.count("Alarms/Count", alarms.as_ref().and_then(|now| now.alarms.len().try_into().ok()));
    list.text("Alarms/Values", alarms.as_ref().map(|now| names(now).join(", ")));
    list.text("Alarms/Run", alarms.and_then(|now| now.run));
    result(&mut list, plant);
    list.0
}

fn result(list: &mut List, plant: &PlantView) {
    let result = plant.result.as_ref();
    list.text("Result/Run", result.map(|result| result.run.clone()));
    list.text("Result/Verdict", result.map(|result| result.verdict.as_str().into()));
    list.text("Result/Why", result.map(|result| result.why.clone()));
    list.text("Result/Missing effects", result.map(|result| result.missing_effects.join(", ")));
    list.number("Result/Residual before", result.map(|result| result.rms_um_before), "um");
    list.number("Result/Residual after", result.map(|result| result.rms_um_after), "um");
    let errors = result.and_then(|result| result.location_errors.as_ref());
    for error in errors.iter().flat_map(|errors| &errors.values) {
        let named = |what: &str| format!("Location errors/{}/{what}", error.symbol);
        list.number(&named("Value"), error.value, &error.unit);
        list.number(&named("u"), error.u, &error.unit);
    }
}

fn device(name: &str, now: &DeviceNow, live: &Live) -> Metrics {
    let mut list = List::default();
    list.text("State", Some(now.state.clone()));
    list.text("Identity", Some(now.identity.clone()));
    list.count("Connections", Some(now.connections.into()));
    list.count("Ends", i64::try_from(now.ends).ok());
    list.count("Lost messages", i64::try_from(now.lost_messages).ok());
    list.text("Last end", now.last_end.clone());
    for probe in live.probes.iter().filter(|probe| probe.device == name) {
        list.number(&format!("Probes/{}/Value", probe.name), probe.value_mm, "mm");
        list.text(&format!("Probes/{}/Remark", probe.name), Some(probe.say.clone()));
    }
    for axis in live.axes.iter().filter(|axis| axis.device == name) {
        list.number(&format!("Axes/{}", axis.name), Some(axis.value), &axis.unit);
    }
    for temperature in live.temperatures.iter().filter(|temperature| temperature.device == name) {
        list.number(&format!("Temperatures/{}", temperature.name), temperature.value_degc, "degC");
    }
    list.0
}

#[derive(Default)]
struct List(Metrics);

impl List {
    fn add(&mut self, name: &str, value: Value, unit: &str) {
        self.0.insert(name.into(), Metric { value, unit: unit.into() });
    }

    fn text(&mut self, name: &str, value: Option<String>) {
        self.add(name, Value::Text(value), "");
    }

    fn count(&mut self, name: &str, value: Option<i64>) {
        self.add(name, Value::Count(value), "");
    }

    fn flag(&mut self, name: &str, value: Option<bool>) {
        self.add(name, Value::Flag(value), "");
    }

    fn number(&mut self, name: &str, value: Option<f64>, unit: &str) {
        self.add(name, Value::Number(value.filter(|value| value.is_finite())), unit);
    }
}
