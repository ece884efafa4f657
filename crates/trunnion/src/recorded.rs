//! What a recording says of how it was measured: machine, cycle, probe directions, channels.

use trunnion_core::channel::roles_of_devices;
use trunnion_core::input::Document;
use trunnion_core::{Channel, Role};
use trunnion_cycles::Cycle;
use trunnion_record::RunHeader;
use trunnion_sync::NestCalibration;
use trunnion_sync::plan::Plan;

/// The plan of a recording that carries its machine, cycle and configuration; `None` when it does not, or when this
/// version cannot read them.
pub fn plan_of(header: &RunHeader) -> Option<Plan> {
    let machine = header.machine()?.ok()?;
    let cycle = Cycle::parse("recorded cycle", &header.cycle_text).ok()?;
    let (nest, configured) = configured(&header.config_text)?;
    // Recordings of before 0.2 name their channels and leave the roles to the configuration.
    let roles = if header.probe_roles.is_empty() { configured } else { header.probe_roles.clone() };
    let channels = roles.into_iter().enumerate().map(|(index, role)| Channel {
        device: 0,
        name: header.probes.get(index).cloned().unwrap_or_default(),
        role,
    });
    Some(Plan { machine, cycle, nest, channels: channels.collect() })
}

/// Probe directions and roles of a recorded configuration, whatever drivers it names.
fn configured(text: &str) -> Option<(NestCalibration, Vec<Role>)> {
    let document = Document::parse("recorded configuration", text).ok()?;
    let root = document.root();
    let nest = match root.optional_table("nest") {
        Some(table) => NestCalibration::read(&table),
        None => Some(NestCalibration::orthogonal()),
    };
    let roles = roles_of_devices(&root);
    drop(root);
    document.finish(nest.zip(roles)).ok()
}
