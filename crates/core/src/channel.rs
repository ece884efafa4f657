//! Channels of displacement: what each is for, and which make up an instrument.

use crate::input::Table;

/// What a channel is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// First, second or third probe of the R-test (0, 1, 2).
    Probe(u8),
    /// Ball bar.
    Bar,
    /// Temperature.
    Temperature,
}

impl Role {
    /// Every role with its name in files.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("probe-1", Self::Probe(0)),
        ("probe-2", Self::Probe(1)),
        ("probe-3", Self::Probe(2)),
        ("bar", Self::Bar),
        ("temperature", Self::Temperature),
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, role)| *role == self).map_or("probe", |(name, _)| name)
    }

    /// Reads the key `role`.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        Self::named(&table.one_of("role", &Self::NAMES.map(|(name, _)| name))?)
    }

    /// The role of this name.
    pub fn named(text: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(name, _)| *name == text).map(|(_, role)| *role)
    }
}

/// One channel of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Index of its device in the configuration.
    pub device: u16,
    /// Name: that of the device, or `device.node-id` where a device has several.
    pub name: String,
    /// What it is for.
    pub role: Role,
}

/// The channels of the R-test in the order probe-1, probe-2, probe-3, or of the ball bar; `None` when incomplete.
pub fn instrument_channels(channels: &[Channel], bar: bool) -> Option<Vec<u16>> {
    let roles = if bar { vec![Role::Bar] } else { (0..3).map(Role::Probe).collect() };
    let find = |role| channels.iter().position(|channel| channel.role == role).map(|index| index as u16);
    roles.into_iter().map(find).collect()
}

/// The roles of all channels of the `[[device]]` tables, in order, whatever their drivers: a device has a `role`, or a
/// list of heads or nodes that have one each. For recordings that do not carry the roles themselves.
pub fn roles_of_devices(root: &Table<'_>) -> Option<Vec<Role>> {
    let of = |device: Table<'_>| -> Option<Vec<Role>> {
        let lists = ["heads", "nodes"];
        match lists.into_iter().find(|list| device.has(list)) {
            Some(list) => device.tables(list).iter().map(Role::read).collect(),
            None if device.has("role") => Some(vec![Role::read(&device)?]),
            None => Some(Vec::new()),
        }
    };
    let devices: Option<Vec<Vec<Role>>> = root.tables("device").into_iter().map(of).collect();
    Some(devices?.concat())
}
