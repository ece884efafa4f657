//! The nodes: `Trunnion` with its state, and below it the result in the names of OPC 40001-101. Ids are paths of names.

use crate::plant::PlantView;
use opcua_server::ServerHandle;
use opcua_server::address_space::{
    ImportedItem, ImportedReference, NodeSetImport, NodeSetNamespaceMapper, NodeType, ObjectBuilder,
    ObjectType, ReferenceDirection, ReferenceType, Variable, VariableType,
};
use opcua_server::node_manager::NodeManagerBuilder;
use opcua_server::node_manager::memory::{SimpleNodeManager, simple_node_manager_imports};
use opcua_types::{
    DataTypeId, DataValue, LocalizedText, NodeId, ObjectId, ObjectTypeId, QualifiedName, ReferenceTypeId,
    VariableId, VariableTypeId, Variant,
};
use std::sync::Arc;
use trunnion::results::{LocationError, Verdict};

/// Of what the standards do not name.
pub const OWN_NAMESPACE: &str = "urn:trunnion:service";
/// Namespaces in the order of their indices.
const NAMESPACES: [&str; 3] =
    ["http://opcfoundation.org/UA/", OWN_NAMESPACE, "http://opcfoundation.org/UA/Machinery/Result/"];
const OWN: u16 = 1;
const RESULT: u16 = 2;

/// Numbers of types in the namespace of OPC 40001-101.
const RESULT_MANAGEMENT_TYPE: u32 = 1004;
const RESULT_TYPE: u32 = 2001;
const RESULT_EVALUATION_ENUM: u32 = 3002;
const RESULT_META_DATA_TYPE: u32 = 3007;
const RESULT_DATA_TYPE: u32 = 3008;
/// `ResultEvaluationEnum`.
const UNDEFINED: i32 = 0;
const NOT_DECIDABLE: i32 = 3;
/// `ServerState`.
const RUNNING: i32 = 0;

/// A variable: path, namespace of its name, data type, rank, value.
type Item = (&'static str, u16, NodeId, i32, fn(&PlantView) -> Variant);

/// Below the object `Trunnion`, each after what carries it.
fn items() -> [Item; 14] {
    let of_result = |number| NodeId::new(RESULT, number);
    let (text, number) = (NodeId::from(DataTypeId::String), NodeId::from(DataTypeId::Double));
    let any = NodeId::from(DataTypeId::BaseDataType);
    [
        ("Trunnion/State", OWN, text.clone(), -1, |view| cycle(view).0.into()),
        ("Trunnion/Run", OWN, text.clone(), -1, |view| cycle(view).1.into()),
        ("Trunnion/Health", OWN, text.clone(), -1, |view| health(view).into()),
        ("Trunnion/Why", OWN, text.clone(), -1, |view| view.why().into()),
        (RESULT_PATH, OWN, of_result(RESULT_DATA_TYPE), -1, |_| Variant::Empty),
        (META_DATA_PATH, RESULT, of_result(RESULT_META_DATA_TYPE), -1, |_| Variant::Empty),
        ("Trunnion/ResultManagement/Results/Result/ResultMetaData/ResultId", RESULT, text.clone(), -1, run),
        (
            "Trunnion/ResultManagement/Results/Result/ResultMetaData/ResultEvaluation",
            RESULT,
            of_result(RESULT_EVALUATION_ENUM),
            -1,
            evaluation,
        ),
        (
            "Trunnion/ResultManagement/Results/Result/ResultMetaData/ResultEvaluationDetails",
            RESULT,
            DataTypeId::LocalizedText.into(),
            -1,
            |view| LocalizedText::from(view.found().as_str()).into(),
        ),
        ("Trunnion/ResultManagement/Results/Result/ResultContent", RESULT, any, 1, |view| {
            let answer = view.result.as_ref().and_then(|result| serde_json::to_string(result).ok());
            answer.into_iter().collect::<Vec<String>>().into()
        }),
        ("Trunnion/ResultManagement/Results/Result/Symbols", OWN, text.clone(), 1, |view| {
            errors(view).iter().map(|error| error.symbol.clone()).collect::<Vec<String>>().into()
        }),
        ("Trunnion/ResultManagement/Results/Result/Values", OWN, number.clone(), 1, |view| {
            errors(view).iter().map(|error| error.value.unwrap_or(f64::NAN)).collect::<Vec<f64>>().into()
        }),
        ("Trunnion/ResultManagement/Results/Result/Uncertainties", OWN, number, 1, |view| {
            errors(view).iter().map(|error| error.u.unwrap_or(f64::NAN)).collect::<Vec<f64>>().into()
        }),
        ("Trunnion/ResultManagement/Results/Result/Units", OWN, text, 1, |view| {
            errors(view).iter().map(|error| error.unit.clone()).collect::<Vec<String>>().into()
        }),
    ]
}

const RESULT_PATH: &str = "Trunnion/ResultManagement/Results/Result";
const META_DATA_PATH: &str = "Trunnion/ResultManagement/Results/Result/ResultMetaData";

fn cycle(view: &PlantView) -> (String, String) {
    let cycle = view.status.cycle.clone().unwrap_or_default();
    (cycle.state.as_str().into(), cycle.run.unwrap_or_default())
}

fn health(view: &PlantView) -> &'static str {
    view.status.health.as_ref().map(|health| health.state).unwrap_or_default().as_str()
}

fn run(view: &PlantView) -> Variant {
    view.result.as_ref().map_or_else(String::new, |result| result.run.clone()).into()
}

/// No result is compared with the tolerance of the machine file here: it says whether there is a verdict.
fn evaluation(view: &PlantView) -> Variant {
    match view.result.as_ref().map(|result| result.verdict) {
        Some(Verdict::NotJudged | Verdict::Undecided) => NOT_DECIDABLE.into(),
        _ => UNDEFINED.into(),
    }
}

/// The location errors that have a value.
fn errors(view: &PlantView) -> Vec<LocationError> {
    let listed = view.result.as_ref().and_then(|result| result.location_errors.as_ref());
    listed.iter().flat_map(|errors| &errors.values).filter(|error| error.value.is_some()).cloned().collect()
}

/// Where the values go.
pub struct Nodes {
    manager: Arc<SimpleNodeManager>,
}

pub fn manager() -> impl NodeManagerBuilder {
    simple_node_manager_imports(vec![Box::new(Base)], "trunnion")
}

impl Nodes {
    /// Adds them to a server that has the [`manager`].
    pub fn add(server: &ServerHandle) -> Result<Self, String> {
        let manager: Arc<SimpleNodeManager> =
            server.node_managers().get_of_type().ok_or("the server has lost its nodes")?;
        {
            let mut space = manager.address_space().write();
            let objects: [(&str, u16, NodeId); 3] = [
                ("Trunnion", OWN, ObjectTypeId::BaseObjectType.into()),
                ("Trunnion/ResultManagement", RESULT, NodeId::new(RESULT, RESULT_MANAGEMENT_TYPE)),
                ("Trunnion/ResultManagement/Results", RESULT, ObjectTypeId::FolderType.into()),
            ];
            for (path, namespace, kind) in objects {
                let (name, above) = name_and_above(path);
                let object = ObjectBuilder::new(&id(path), named(namespace, name), name).build();
                space.insert(object, Some(&references(&above, &kind)));
            }
            for (path, namespace, data_type, rank, _) in items() {
                let (name, above) = name_and_above(path);
                let none: Option<u32> = None;
                let mut variable = Variable::new_data_value(
                    &id(path),
                    named(namespace, name),
                    name,
                    data_type,
                    None,
                    none,
                    Variant::Empty,
                );
                variable.set_value_rank(rank);
                let kind = match path {
                    RESULT_PATH => NodeId::new(RESULT, RESULT_TYPE),
                    _ => VariableTypeId::BaseDataVariableType.into(),
                };
                space.insert(variable, Some(&references(&above, &kind)));
            }
        }
        Ok(Self { manager })
    }

    /// Sets all values, and queues what changed for the clients that watch it.
    pub fn set(&self, server: &ServerHandle, view: &PlantView) -> Result<(), String> {
        let values: Vec<(NodeId, DataValue)> = items()
            .into_iter()
            .map(|(path, _, _, _, value)| (id(path), DataValue::new_now(value(view))))
            .collect();
        let values = values.iter().map(|(node, value)| (node, None, value.clone()));
        let set = self.manager.set_values(server.subscriptions(), values);
        set.map_err(|status| format!("a value was refused ({status})"))
    }
}

fn id(path: &str) -> NodeId {
    NodeId::new(OWN, path)
}

/// The last name of a path, and the node that carries it.
fn name_and_above(path: &str) -> (&str, NodeId) {
    match path.rsplit_once('/') {
        Some((above, name)) => (name, id(above)),
        None => (path, ObjectId::ObjectsFolder.into()),
    }
}

fn references<'a>(
    above: &'a NodeId,
    kind: &'a NodeId,
) -> [(&'a NodeId, &'static ReferenceTypeId, ReferenceDirection); 2] {
    [
        (above, &ReferenceTypeId::HasComponent, ReferenceDirection::Inverse),
        (kind, &ReferenceTypeId::HasTypeDefinition, ReferenceDirection::Forward),
    ]
}

fn named(namespace_index: u16, name: &str) -> QualifiedName {
    QualifiedName { namespace_index, name: name.into() }
}

/// The types of our nodes: a server names only types that it has.
fn types() -> [NodeType; 5] {
    let object = |id: NodeId, namespace, name: &str| -> NodeType {
        ObjectType::new(&id, named(namespace, name), name, false).into()
    };
    let variable = |id: NodeId, namespace, name: &str, kind: NodeId| -> NodeType {
        VariableType::new(&id, named(namespace, name), name, kind, false, -2).into()
    };
    let of_result = |number| NodeId::new(RESULT, number);
    let any = DataTypeId::BaseDataType;
    [
        object(ObjectTypeId::BaseObjectType.into(), 0, "BaseObjectType"),
        object(ObjectTypeId::FolderType.into(), 0, "FolderType"),
        object(of_result(RESULT_MANAGEMENT_TYPE), RESULT, "ResultManagementType"),
        variable(VariableTypeId::BaseDataVariableType.into(), 0, "BaseDataVariableType", any.into()),
        variable(of_result(RESULT_TYPE), RESULT, "ResultType", of_result(RESULT_DATA_TYPE)),
    ]
}

/// Of the namespace of OPC UA what browsing to our nodes needs, and what clients ask of every server. The whole of it would take
/// minutes to compile.
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
        use ReferenceTypeId as Id;
        let objects = ObjectBuilder::new(&ObjectId::ObjectsFolder.into(), "Objects", "Objects").build();
        let reference = |id: Id, name: &str, above: Id| ImportedItem {
            node: ReferenceType::new(&id.into(), name, name, None, false, false).into(),
            references: vec![ImportedReference {
                target_id: above.into(),
                type_id: Id::HasSubtype.into(),
                is_forward: false,
            }],
        };
        let variable = |id: VariableId, name: &str, kind: DataTypeId, value: Variant| {
            let none: Option<u32> = None;
            let variable = Variable::new_data_value(&id.into(), name, name, kind, None, none, value);
            ImportedItem { node: variable.into(), references: Vec::new() }
        };
        let names = NAMESPACES.map(str::to_owned).to_vec();
        Box::new(
            [
                ImportedItem { node: NodeType::from(objects), references: Vec::new() },
                reference(Id::HierarchicalReferences, "HierarchicalReferences", Id::References),
                reference(Id::NonHierarchicalReferences, "NonHierarchicalReferences", Id::References),
                reference(Id::HasTypeDefinition, "HasTypeDefinition", Id::NonHierarchicalReferences),
                reference(Id::HasChild, "HasChild", Id::HierarchicalReferences),
                reference(Id::Aggregates, "Aggregates", Id::HasChild),
                reference(Id::HasComponent, "HasComponent", Id::Aggregates),
                variable(
                    VariableId::Server_NamespaceArray,
                    "NamespaceArray",
                    DataTypeId::String,
                    names.into(),
                ),
                variable(VariableId::Server_ServerStatus_State, "State", DataTypeId::Int32, RUNNING.into()),
            ]
            .into_iter()
            .chain(types().map(|node| ImportedItem { node, references: Vec::new() })),
        )
    }
}
