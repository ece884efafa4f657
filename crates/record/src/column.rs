//! Columns of a points file: what each holds and what it is called (docs/design/contracts.md §2).

use trunnion_core::{InstrumentKind, Joint, ReadingColumn};

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Column {
    Setup,
    Time,
    Position(Joint),
    Direction(Joint),
    Target,
    Reading(ReadingColumn),
    Temperature(String),
    /// Path speed of the linear axes.
    Feed,
    /// What the encoder of an axis read.
    Actual(Joint),
    Speed(Joint),
    Acceleration(Joint),
    SinceReversal(Joint),
    /// Samples behind a reading, and their spread by component.
    Samples,
    Spread(&'static str),
}

impl Column {
    /// The column of this name out of `allowed`. Any other `NAME_degc` is a temperature.
    pub fn parse(name: &str, allowed: &[Self]) -> Option<Self> {
        let temperature = || name.strip_suffix("_degc").filter(|name| !name.is_empty());
        let known = allowed.iter().find(|column| column.name() == name).cloned();
        known.or_else(|| temperature().map(|name| Self::Temperature(name.into())))
    }

    /// Name with unit.
    pub fn name(&self) -> String {
        let of = |joint: &Joint, what: &str| format!("{}{what}_{}", joint.lower(), unit(*joint));
        match self {
            Self::Setup => "setup".into(),
            Self::Time => "time_s".into(),
            Self::Position(joint) => of(joint, ""),
            Self::Direction(joint) => format!("direction_{}", joint.lower()),
            Self::Target => "target".into(),
            Self::Reading(column) => column.name().into(),
            Self::Temperature(name) => format!("{name}_degc"),
            Self::Feed => "feed_mm_per_min".into(),
            // A spindle has no commanded angle to distinguish it from.
            Self::Actual(joint) if joint.lower() == SPINDLE => of(joint, ""),
            Self::Actual(joint) => of(joint, "_actual"),
            Self::Speed(joint) => of(joint, "_speed") + "_per_s",
            Self::Acceleration(joint) => of(joint, "_acceleration") + "_per_s2",
            Self::SinceReversal(joint) => of(joint, "_since_reversal"),
            Self::Samples => "samples".into(),
            Self::Spread(component) => format!("spread_{component}_um"),
        }
    }
}

/// Name of a spindle among the joints of a machine, lower case.
const SPINDLE: &str = "spindle";

/// The joint of the spindle where the machine does not have it as one of `joints`: its angle is only recorded.
pub fn spindle_of(joints: &[Joint]) -> Option<Joint> {
    let mut chain: Vec<(&str, bool)> =
        joints.iter().map(|joint| (joint.as_str(), joint.is_rotary())).collect();
    if joints.iter().any(|joint| joint.lower() == SPINDLE) {
        return None;
    }
    chain.push((SPINDLE, true));
    Joint::chain(&chain).ok().and_then(|chain| chain.last().copied())
}

/// Columns that only a table on the fly may have.
pub fn on_the_fly(joints: &[Joint], kinds: impl Iterator<Item = InstrumentKind>) -> Vec<Column> {
    let mut columns = vec![Column::Feed, Column::Samples];
    columns.extend(joints.iter().copied().chain(spindle_of(joints)).map(Column::Actual));
    for of in [Column::Speed, Column::Acceleration, Column::SinceReversal] {
        columns.extend(joints.iter().copied().map(of));
    }
    for component in kinds.flat_map(|kind| kind.components()) {
        if !columns.contains(&Column::Spread(component)) {
            columns.push(Column::Spread(component));
        }
    }
    columns
}

/// The columns that hold the readings of these instruments, each once, in the order of the kinds.
pub fn readings(kinds: impl Iterator<Item = InstrumentKind> + Clone) -> Vec<ReadingColumn> {
    let mut columns: Vec<ReadingColumn> = Vec::new();
    for (_, kind) in InstrumentKind::NAMES {
        if kinds.clone().any(|other| other == kind) {
            columns
                .extend(kind.columns().iter().filter(|column| !columns.contains(column)).collect::<Vec<_>>());
        }
    }
    columns
}

fn unit(joint: Joint) -> &'static str {
    if joint.is_rotary() { "deg" } else { "mm" }
}
