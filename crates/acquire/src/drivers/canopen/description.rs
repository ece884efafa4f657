//! What a node says of itself, against its line in the configuration.

use crate::session_end::SessionEnd;
use trunnion_core::Role;
use trunnion_protocol::canopen::cia404::Quantity;
use trunnion_protocol::canopen::node::Scaling;
use trunnion_protocol::canopen::{NodeDescription, NodeId, Profile};

/// A configured node.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeConfig {
    pub(super) id: NodeId,
    pub(super) role: Role,
    pub(super) serial: Option<u32>,
    /// Of a bar: what it shows at its length, mm, where the configuration says it.
    pub(super) bar_zero_mm: Option<f64>,
}

/// Checks profile, serial number and that the node sends what its role needs.
pub(super) fn check(config: &NodeConfig, found: &NodeDescription) -> Result<(), SessionEnd> {
    let wrong = |expected: String| SessionEnd::WrongDevice { found: identity(found), expected };
    let id = config.id.get();
    if matches!(found.profile(), Profile::Other(_)) {
        return Err(wrong(format!("node {id} with profile CiA 404 or CiA 406")));
    }
    if let Some(serial) = config.serial.filter(|&serial| found.identity.serial != Some(serial)) {
        return Err(wrong(format!("node {id} with serial number {serial}")));
    }
    if found.tpdos.is_empty() {
        return Err(SessionEnd::Protocol {
            doing: "reading a node's description",
            fault: format!("node {id} has no TPDO switched on; map its process value to a TPDO"),
        });
    }
    Ok(())
}

/// One node in words.
pub(super) fn identity(found: &NodeDescription) -> String {
    let profile = match found.profile() {
        Profile::MeasuringDevice => "CiA 404".into(),
        Profile::Encoder => "CiA 406".into(),
        Profile::Other(number) => format!("profile {number}"),
    };
    let name = found.name.as_deref().unwrap_or("unnamed");
    let product = found.identity.product.map_or(String::new(), |product| format!(" product {product:X}h"));
    let serial = found.identity.serial.map_or(String::new(), |serial| format!(" serial {serial}"));
    format!("node {} {name} {profile} vendor {:X}h{product}{serial}", found.node.get(), found.identity.vendor)
}

/// True for one that measures temperatures alone.
pub(super) fn is_thermometer(found: &NodeDescription) -> bool {
    let mut lengths_or_temperatures = found.scaling.values().filter_map(|scaling| match scaling {
        Scaling::Process { unit, .. } => Some(matches!(unit.quantity(0.0), Quantity::TemperatureC(_))),
        Scaling::Position { .. } => Some(false),
        _ => None,
    });
    lengths_or_temperatures.next() == Some(true)
        && lengths_or_temperatures.all(|is_temperature| is_temperature)
}
