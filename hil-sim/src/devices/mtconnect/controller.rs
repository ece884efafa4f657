//! The controller: which data items it has, and one line of values per cycle of its own clock.

use super::AgentConfig;
use super::wall_clock::WallClock;
use crate::devices::clock::TimeOrigin;
use crate::devices::cycles::Cycles;
use crate::devices::world::World;
use std::sync::Arc;
use trunnion_protocol::mtconnect::{Category, Component, DataItem, Device, ObservedValue};

/// Values of one instant, one for each data item.
pub(super) struct Line {
    pub wall_ns: i64,
    pub values: Vec<ObservedValue>,
}

pub(super) struct Controller {
    world: Arc<dyn World>,
    config: AgentConfig,
    items: Vec<DataItem>,
    /// One line each.
    cycles: Cycles,
    link_lost_until_s: f64,
    /// Positions are those of the first time until the second, s.
    stuck_s: Option<(f64, f64)>,
}

impl Controller {
    pub fn new(world: Arc<dyn World>, config: AgentConfig, now_s: f64) -> Self {
        let items = data_items(&config);
        let cycles = Cycles::new(config.clock, config.rate_hz, now_s);
        Self { world, config, items, cycles, link_lost_until_s: f64::NEG_INFINITY, stuck_s: None }
    }

    pub fn items(&self) -> &[DataItem] {
        &self.items
    }

    pub fn devices(&self) -> Vec<Device> {
        let name = self.config.device.clone();
        vec![Device { id: "d1".into(), uuid: name.clone(), name, data_items: self.items.clone() }]
    }

    pub fn wall_clock(&self, origin: TimeOrigin) -> WallClock {
        WallClock { origin, ns_at_origin: self.config.wall_ns_at_origin, clock: self.config.clock }
    }

    /// What the controller's wall clock shows at `t_s`, ns since 1970 UTC.
    pub fn wall_ns(&self, t_s: f64) -> i64 {
        self.config.wall_ns_at_origin + (self.config.clock.device_s(t_s) * 1e9).round() as i64
    }

    /// The link to the agent is down until then.
    pub fn lose_link(&mut self, until_s: f64) {
        self.link_lost_until_s = self.link_lost_until_s.max(until_s);
    }

    /// The axes show no motion from now on.
    pub fn stick(&mut self, now_s: f64, duration_s: f64) {
        self.stuck_s = Some((now_s, now_s + duration_s));
    }

    /// The wall clock is set.
    pub fn set_clock(&mut self, by_s: f64) {
        self.config.clock.offset_s += by_s;
    }

    /// When the next line is due, time of the cell, s.
    pub fn due_s(&self) -> f64 {
        self.cycles.due_s()
    }

    /// The lines up to now.
    pub fn lines(&mut self, now_s: f64) -> Vec<Line> {
        self.cycles.take(now_s).map(|cycle| self.line(self.cycles.at_s(cycle as f64))).collect()
    }

    fn line(&self, t_s: f64) -> Line {
        let wall_ns = self.wall_ns(t_s) / 1000 * 1000; // agents stamp in µs
        if t_s < self.link_lost_until_s {
            return Line { wall_ns, values: vec![ObservedValue::Unavailable; self.items.len()] };
        }
        let stuck_s = self.stuck_s.filter(|(_, until_s)| t_s < *until_s);
        let axes = self.world.axes(stuck_s.map_or(t_s, |(since_s, _)| since_s));
        let cycle = self.world.cycle(t_s);
        let text = |text: &str| ObservedValue::Text(text.into());
        let mut values = vec![text("AVAILABLE")];
        for &axis in &self.config.axes {
            values.push(ObservedValue::Number(if axis.is_rotary() {
                rounded(axes[axis].to_degrees(), self.config.resolution_deg)
            } else {
                rounded(axes[axis], self.config.resolution_mm)
            }));
        }
        let shown = self.config.shown.iter().find(|shown| (shown.from_s..shown.to_s).contains(&t_s));
        let by_motion = if cycle.running { "ACTIVE" } else { "READY" };
        values.push(text(shown.map_or(by_motion, |shown| shown.execution)));
        values.push(text("AUTOMATIC"));
        values.push(text(&cycle.program));
        values.push(ObservedValue::Text(format!("N{}", cycle.block)));
        values.push(ObservedValue::Text(cycle.block.to_string()));
        values.push(ObservedValue::Number(rounded(self.world.temperature_degc(t_s), 0.01)));
        if !self.config.numbers.is_empty() {
            let is_it = |(name, _): &&(String, u32)| cycle.running && *name == cycle.program;
            let number = self.config.numbers.iter().find(is_it).map_or(0, |(_, number)| *number);
            values.push(ObservedValue::Text(number.to_string()));
        }
        Line { wall_ns, values }
    }
}

/// The nearest multiple of a resolution such as 1e-4, as a number without rounding dust.
fn rounded(value: f64, resolution: f64) -> f64 {
    let per_unit = (1.0 / resolution).round();
    // + 0.0 makes −0 a 0
    (value * per_unit).round() / per_unit + 0.0
}

/// The data items in the order of a line.
fn data_items(config: &AgentConfig) -> Vec<DataItem> {
    let component =
        |kind: &str, id: &str, name: &str| Component { kind: kind.into(), id: id.into(), name: name.into() };
    let item = |id: String, category, kind: &str, sub_type: Option<&str>, units: Option<&str>, component| {
        let (kind, sub_type, units) = (kind.into(), sub_type.map(str::to_owned), units.map(str::to_owned));
        DataItem {
            name: Some(id.clone()),
            id,
            category,
            kind,
            sub_type,
            units,
            coordinate_system: None,
            component,
        }
    };
    let device = component("Device", "d1", &config.device);
    let mut items = vec![item("avail".into(), Category::Event, "AVAILABILITY", None, None, device)];
    for axis in &config.axes {
        let id = axis.lower();
        let (kind, quantity, unit) = if axis.is_rotary() {
            ("Rotary", "ANGLE", "DEGREE")
        } else {
            ("Linear", "POSITION", "MILLIMETER")
        };
        let of_axis = component(kind, id, axis.as_str());
        let mut item =
            item(format!("{}act", axis), Category::Sample, quantity, Some("ACTUAL"), Some(unit), of_axis);
        item.coordinate_system = Some("MACHINE".into());
        items.push(item);
    }
    let controller = component("Controller", "cont", "controller");
    let path = component("Path", "path", "path");
    items.push(item("execution".into(), Category::Event, "EXECUTION", None, None, path.clone()));
    items.push(item("mode".into(), Category::Event, "CONTROLLER_MODE", None, None, path.clone()));
    items.push(item("program".into(), Category::Event, "PROGRAM", None, None, path.clone()));
    items.push(item("block".into(), Category::Event, "BLOCK", None, None, path.clone()));
    items.push(item("line".into(), Category::Event, "LINE_NUMBER", Some("ABSOLUTE"), None, path.clone()));
    items.push(item("temp".into(), Category::Sample, "TEMPERATURE", None, Some("CELSIUS"), controller));
    if !config.numbers.is_empty() {
        items.push(item("cycle".into(), Category::Event, "VARIABLE", None, None, path));
    }
    items
}
