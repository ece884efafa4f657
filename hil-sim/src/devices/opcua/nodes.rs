//! The nodes of the controller: positions `ns=2;s=/Channel/MachineAxis/measPos1[u1,n]`, and the program's name, state and
//! block. Of the server's own namespace there is what browsing to them needs.

use super::without_link::WithoutLink;
use crate::devices::world::CycleState;
use opcua_server::ServerHandle;
use opcua_server::address_space::{
    ImportedItem, ImportedReference, NodeSetImport, NodeSetNamespaceMapper, NodeType, ObjectBuilder,
    ReferenceType, Variable,
};
use opcua_server::node_manager::NodeManagerBuilder;
use opcua_server::node_manager::memory::{SimpleNodeManager, simple_node_manager_imports};
use opcua_types::{
    DataTypeId, DataValue, DateTime, NodeId, ObjectId, QualifiedName, ReferenceTypeId, Variant,
};
use std::sync::Arc;
use trunnion_core::Joint;

/// Namespaces in the order of their indices.
const NAMESPACES: [&str; 3] =
    ["http://opcfoundation.org/UA/", "urn:trunnion:virtual-controller", "SinumerikVarProvider"];
/// Index of the last.
const OURS: u16 = 2;
/// 100 ns ticks of OPC UA from 1601 to 1970.
const TICKS_TO_1970: i64 = 116_444_736_000_000_000;
/// `progStatus`.
const IN_PROGRESS: u16 = 3;
const ABORTED: u16 = 5;

/// What the controller knows of one cycle.
pub(super) struct Sampled {
    /// Position in mm or degrees, `None` without link to the controller, and its stamp, ns since 1970.
    pub axes: Vec<(Option<f64>, i64)>,
    /// What is sent in place of a position.
    pub without_link: WithoutLink,
    pub state: Option<CycleState>,
    pub stamp_ns: i64,
}

/// Where the values go.
pub(super) struct Nodes {
    manager: Arc<SimpleNodeManager>,
    axes: Vec<NodeId>,
    program: NodeId,
    state: NodeId,
    block: NodeId,
}

pub(super) fn manager() -> impl NodeManagerBuilder {
    simple_node_manager_imports(vec![Box::new(Base)], "controller")
}

impl Nodes {
    /// Adds them to a server that has the [`manager`].
    pub fn add(server: &ServerHandle, axes: &[Joint]) -> Result<Self, String> {
        let manager: Arc<SimpleNodeManager> =
            server.node_managers().get_of_type().ok_or("the server has lost its nodes")?;
        let node = |path: String| NodeId::new(OURS, path);
        let folder = node("Sinumerik".into());
        let nodes = Self {
            axes: (1..=axes.len()).map(|n| node(format!("/Channel/MachineAxis/measPos1[u1,{n}]"))).collect(),
            program: node("/Channel/ProgramInfo/progName[u1]".into()),
            state: node("/Channel/State/progStatus[u1]".into()),
            block: node("/Channel/ProgramInfo/block[u1]".into()),
            manager,
        };
        let (double, string, number) = (DataTypeId::Double, DataTypeId::String, DataTypeId::UInt16);
        let kinds = nodes.axes.iter().map(|axis| (axis, double));
        let kinds = kinds.chain([(&nodes.program, string), (&nodes.block, string), (&nodes.state, number)]);
        let variables = kinds.map(|(node, kind)| {
            let name = node.identifier.to_string();
            let none: Option<u32> = None;
            Variable::new_data_value(node, named(&name), name.as_str(), kind, None, none, Variant::Empty)
        });
        let variables = variables.collect();
        {
            let mut space = nodes.manager.address_space().write();
            space.add_folder(&folder, named("Sinumerik"), "Sinumerik", &ObjectId::ObjectsFolder.into());
            space.add_variables(variables, &folder);
        }
        Ok(nodes)
    }

    /// Sets all values, and queues them for the clients that watch them.
    pub fn set(&self, server: &ServerHandle, sampled: &Sampled) -> Result<(), String> {
        let state = sampled.state.as_ref();
        let number = |state: &CycleState| if state.running { IN_PROGRESS } else { ABORTED };
        let axes = sampled.axes.iter().map(|(position, stamp_ns)| match position {
            Some(position) => DataValue::new_at(*position, date(*stamp_ns)),
            None => sampled.without_link.value(date(*stamp_ns)),
        });
        let values = self.axes.iter().zip(axes).chain([
            (&self.program, stamped(state.map(|state| state.program.clone()), sampled.stamp_ns)),
            (&self.state, stamped(state.map(number), sampled.stamp_ns)),
            (&self.block, stamped(state.map(|state| format!("N{}", state.block)), sampled.stamp_ns)),
        ]);
        let values = values.map(|(node, value)| (node, None, value));
        let set = self.manager.set_values(server.subscriptions(), values);
        set.map_err(|status| format!("a value was refused ({status})"))
    }
}

/// A value, or why there is none.
fn stamped<T: Into<Variant>>(value: Option<T>, stamp_ns: i64) -> DataValue {
    match value {
        Some(value) => DataValue::new_at(value, date(stamp_ns)),
        None => WithoutLink::BadNull.value(date(stamp_ns)),
    }
}

fn date(stamp_ns: i64) -> DateTime {
    DateTime::from(stamp_ns / 100 + TICKS_TO_1970)
}

fn named(name: &str) -> QualifiedName {
    QualifiedName { namespace_index: OURS, name: name.into() }
}

/// Objects, and the references by which it has things. The whole standard namespace would take minutes to compile.
struct Base;

impl NodeSetImport for Base {
    fn register_namespaces(&self, namespaces: &mut NodeSetNamespaceMapper<'_>) {
        for (index, name) in (0..).zip(NAMESPACES) {
            namespaces.add_namespace(name, index);
        }
    }

    fn get_own_namespaces(&self) -> Vec<String> {
        NAMESPACES.map(str::to_owned).to_vec()
    }

    fn load<'a>(
        &'a self,
        _namespaces: &'a NodeSetNamespaceMapper<'_>,
    ) -> Box<dyn Iterator<Item = ImportedItem> + 'a> {
        let objects = ObjectBuilder::new(&ObjectId::ObjectsFolder.into(), "Objects", "Objects").build();
        let objects = ImportedItem { node: NodeType::from(objects), references: Vec::new() };
        let reference = |id: ReferenceTypeId, name: &str, above: ReferenceTypeId| ImportedItem {
            node: ReferenceType::new(&id.into(), name, name, None, false, false).into(),
            references: vec![ImportedReference {
                target_id: above.into(),
                type_id: ReferenceTypeId::HasSubtype.into(),
                is_forward: false,
            }],
        };
        Box::new(
            [
                objects,
                reference(
                    ReferenceTypeId::HierarchicalReferences,
                    "HierarchicalReferences",
                    ReferenceTypeId::References,
                ),
                reference(ReferenceTypeId::Organizes, "Organizes", ReferenceTypeId::HierarchicalReferences),
            ]
            .into_iter(),
        )
    }
}
