//! Which nodes hold what: given, numbered, or found by browsing.

use super::connect::{Connection, limited};
use super::settings::{Layout, OpcUa};
use crate::axis_name::letter_of;
use crate::execution::{OPC_40502, SINUMERIK, Vocabulary};
use crate::link::Link;
use crate::session_end::SessionEnd;
use opcua::types::{
    AttributeId, BrowseDescription, BrowseDirection, BrowseResultMask, EUInformation, NodeId, ObjectId,
    ReadValueId, ReferenceTypeId, StatusCode, TimestampsToReturn, Variant,
};
use std::f64::consts::PI;
use std::str::FromStr;
use trunnion_core::Joint;

/// Levels and nodes looked through below Objects for `CncAxisList`.
const DEEPEST: usize = 5;
const MOST_NODES: usize = 500;
/// What holds the axes of OPC 40502.
pub(super) const AXIS_LIST: &str = "CncAxisList";
/// The position of an axis of OPC 40502 when nobody names another.
pub(super) const USUAL_POSITION: &str = "PosDirect";
/// Answers to one browse.
const MOST_PAGES: usize = 20;

/// The nodes of a controller.
pub(super) struct Nodes {
    pub(super) axes: Vec<AxisNode>,
    pub(super) program: Option<NodeId>,
    pub(super) state: Option<NodeId>,
    pub(super) block: Option<NodeId>,
    pub(super) signal: Option<NodeId>,
    pub(super) numbers: &'static Vocabulary,
}

/// The node of an axis.
pub(super) struct AxisNode {
    pub(super) letter: Joint,
    pub(super) node: NodeId,
    /// Size of its unit in mm or rad.
    pub(super) unit: f64,
}

/// Finds them.
pub(super) async fn find(
    device: &OpcUa,
    connection: &Connection,
    link: &mut Link,
) -> Result<Nodes, SessionEnd> {
    let browser = Browser { device, connection };
    let given = |text: &Option<String>| text.as_deref().map(node_id).transpose();
    let mut nodes = Nodes {
        axes: Vec::new(),
        program: given(&device.named.program)?,
        state: given(&device.named.state)?,
        block: given(&device.named.block)?,
        signal: given(&device.named.signal)?,
        numbers: &OPC_40502,
    };
    let mut found: Vec<(Joint, NodeId)> = Vec::new();
    let mut known = [None, None, None];
    match &device.layout {
        Layout::Nodes(named) => {
            for letter in Joint::ISO {
                if let Some(text) = &named[letter] {
                    found.push((letter, node_id(text)?));
                }
            }
        }
        Layout::Sinumerik { axes, unit } => {
            nodes.numbers = &SINUMERIK;
            for (number, &letter) in (1..).zip(axes) {
                found.push((letter, machine_axis(unit, number)));
            }
            known = ["ProgramInfo/progName", "State/progStatus", "ProgramInfo/block"]
                .map(|name| Some(sinumerik(&format!("/Channel/{name}[{unit}]"))));
        }
        Layout::Opc40502 { axes, position } => {
            let (lists, listed) = browser.axes(position).await?;
            found = listed;
            found.retain(|(letter, _)| axes.as_ref().is_none_or(|axes| axes.contains(letter)));
            known = browser.channel(&lists).await?;
        }
    }
    let wanted: Vec<NodeId> = found.iter().map(|(_, node)| node.clone()).collect();
    let values = browser.values(&wanted).await?;
    let missing = |(_, status): &(_, &StatusCode)| is_missing(**status);
    let statuses: Vec<StatusCode> = values.iter().map(|(status, _)| *status).collect();
    let absent: Vec<String> =
        found.iter().zip(&statuses).filter(missing).map(|((l, n), _)| format!("{n} ({l})")).collect();
    if !absent.is_empty() || found.is_empty() {
        let there: Vec<String> = found
            .iter()
            .zip(&statuses)
            .filter(|pair| !missing(pair))
            .map(|((_, n), _)| n.to_string())
            .collect();
        let expected = if absent.is_empty() { "positions of axes".into() } else { absent.join(", ") };
        let objects = browser.names_below(&ObjectId::ObjectsFolder.into()).await?;
        return Err(SessionEnd::WrongDevice {
            found: format!("a server with {}; below Objects it has {}", list(&there), list(&objects)),
            expected,
        });
    }
    for (letter, node) in found {
        let unit = browser.unit(&node, letter).await?;
        nodes.axes.push(AxisNode { letter, node, unit });
    }
    let [program, state, block] = known;
    for (place, known, what) in [
        (&mut nodes.program, program, "program"),
        (&mut nodes.state, state, "state"),
        (&mut nodes.block, block, "block"),
    ] {
        let Some(known) = known.filter(|_| place.is_none()) else { continue };
        let value = browser.values(std::slice::from_ref(&known)).await?;
        // A node that has no value at present may have one later.
        if value.first().is_some_and(|(status, _)| may_have_values(*status)) {
            *place = Some(known);
        } else {
            link.log(false, format!("{known} is not there; name the node of the {what} by the key `{what}`"));
        }
    }
    Ok(nodes)
}

pub(super) fn is_missing(status: StatusCode) -> bool {
    matches!(status, StatusCode::BadNodeIdUnknown | StatusCode::BadNodeIdInvalid)
}

fn may_have_values(status: StatusCode) -> bool {
    let never = matches!(
        status,
        StatusCode::BadUserAccessDenied | StatusCode::BadNotReadable | StatusCode::BadAttributeIdInvalid
    );
    !never && !is_missing(status)
}

/// The measured position of a machine axis of a SINUMERIK, counted from 1.
pub(super) fn machine_axis(unit: &str, number: usize) -> NodeId {
    sinumerik(&format!("/Channel/MachineAxis/measPos1[{unit},{number}]"))
}

fn sinumerik(path: &str) -> NodeId {
    NodeId::new(2, path)
}

fn node_id(text: &str) -> Result<NodeId, SessionEnd> {
    NodeId::from_str(text).map_err(|_| SessionEnd::WrongDevice {
        found: format!("\"{text}\" in the configuration"),
        expected: "a node id such as ns=2;s=/Path or ns=4;i=1234".into(),
    })
}

pub(super) fn list(names: &[String]) -> String {
    const SHOWN: usize = 12;
    match names {
        [] => "nothing".into(),
        names if names.len() > SHOWN => {
            format!("{} and {} more", names[..SHOWN].join(", "), names.len() - SHOWN)
        }
        names => names.join(", "),
    }
}

/// Asks a server what it has.
pub(super) struct Browser<'a> {
    pub(super) device: &'a OpcUa,
    pub(super) connection: &'a Connection,
}

impl Browser<'_> {
    /// `CncAxisList/<axis>/<position>/ActPos` of every axis named by a letter, and the folder that holds the list.
    pub(super) async fn axes(&self, position: &str) -> Result<(NodeId, Vec<(Joint, NodeId)>), SessionEnd> {
        let wrong = |found: String, expected: String| SessionEnd::WrongDevice { found, expected };
        let Some((parent, list_node)) = self.search(AXIS_LIST).await? else {
            let objects = self.names_below(&ObjectId::ObjectsFolder.into()).await?;
            let found = format!("a server without CncAxisList; below Objects it has {}", list(&objects));
            return Err(wrong(found, "an OPC 40502 server; or name the nodes (layout = \"nodes\")".into()));
        };
        let mut found = Vec::new();
        for (name, axis) in self.children(&list_node).await? {
            let Some(letter) = letter_of(&name) else { continue };
            let positions = self.children(&axis).await?;
            let Some((_, node)) = positions.iter().find(|(name, _)| name == position) else {
                let names: Vec<String> = positions.into_iter().map(|(name, _)| name).collect();
                let found = format!("axis {name} with {}", list(&names));
                return Err(wrong(found, format!("{position}; correct the key `position`")));
            };
            let values = self.children(node).await?;
            let Some((_, actual)) = values.iter().find(|(name, _)| name == "ActPos") else {
                let names: Vec<String> = values.into_iter().map(|(name, _)| name).collect();
                return Err(wrong(format!("{name}/{position} with {}", list(&names)), "ActPos".into()));
            };
            found.push((letter, actual.clone()));
        }
        if found.is_empty() {
            let names = self.names_below(&list_node).await?;
            let found = format!("a CncAxisList with {}", list(&names));
            return Err(wrong(found, "axes named X, Y, Z, A, B, C".into()));
        }
        Ok((parent, found))
    }

    /// Main program's name, program status and block of the first channel of `CncChannelList`, which stands next to the axes.
    async fn channel(&self, parent: &NodeId) -> Result<[Option<NodeId>; 3], SessionEnd> {
        let siblings = self.children(parent).await?;
        let Some((_, channels)) = siblings.iter().find(|(name, _)| name == "CncChannelList") else {
            return Ok([None, None, None]);
        };
        let channels = self.children(channels).await?;
        let mut found = [None, None, None];
        for (_, channel) in &channels {
            let values = self.children(channel).await?;
            found = ["ActMainProgramName", "ActProgramStatus", "ActProgramBlock"]
                .map(|wanted| values.iter().find(|(name, _)| name == wanted).map(|(_, node)| node.clone()));
            if found[1].is_some() {
                break;
            }
        }
        Ok(found)
    }

    /// The first node of this name below Objects, with its parent, level by level.
    pub(super) async fn search(&self, wanted: &str) -> Result<Option<(NodeId, NodeId)>, SessionEnd> {
        let mut level: Vec<NodeId> = vec![ObjectId::ObjectsFolder.into()];
        let mut seen = 0;
        for _ in 0..DEEPEST {
            let mut below = Vec::new();
            for parent in level {
                for (name, node) in self.children(&parent).await? {
                    if name == wanted {
                        return Ok(Some((parent, node)));
                    }
                    seen += 1;
                    // The server describes itself at length under namespace 0.
                    if node.namespace != 0 && seen <= MOST_NODES {
                        below.push(node);
                    }
                }
            }
            level = below;
        }
        Ok(None)
    }

    pub(super) async fn names_below(&self, node: &NodeId) -> Result<Vec<String>, SessionEnd> {
        Ok(self.children(node).await?.into_iter().map(|(name, _)| name).collect())
    }

    /// Browse names and ids of what a node has.
    async fn children(&self, node: &NodeId) -> Result<Vec<(String, NodeId)>, SessionEnd> {
        let what = BrowseDescription {
            node_id: node.clone(),
            browse_direction: BrowseDirection::Forward,
            reference_type_id: ReferenceTypeId::HierarchicalReferences.into(),
            include_subtypes: true,
            node_class_mask: 0,
            result_mask: BrowseResultMask::BrowseName as u32,
        };
        let session = &self.connection.session;
        let mut answers = limited(self.device, session.browse(&[what], 0, None)).await?;
        let mut children = Vec::new();
        for _ in 0..MOST_PAGES {
            let Some(answer) = answers.pop() else { break };
            for reference in answer.references.into_iter().flatten() {
                children.push((reference.browse_name.name.as_ref().to_owned(), reference.node_id.node_id));
            }
            if answer.continuation_point.is_null_or_empty() {
                break;
            }
            answers = limited(self.device, session.browse_next(false, &[answer.continuation_point])).await?;
        }
        Ok(children)
    }

    pub(super) async fn values(
        &self,
        nodes: &[NodeId],
    ) -> Result<Vec<(StatusCode, Option<Variant>)>, SessionEnd> {
        let read: Vec<ReadValueId> =
            nodes.iter().map(|node| ReadValueId::new(node.clone(), AttributeId::Value)).collect();
        let values =
            limited(self.device, self.connection.session.read(&read, TimestampsToReturn::Source, 0.0))
                .await?;
        Ok(values.into_iter().map(|value| (value.status(), value.value)).collect())
    }

    /// Size of the node's unit in mm or rad: by its `EngineeringUnits` (UNECE codes), else mm and degrees.
    async fn unit(&self, node: &NodeId, letter: Joint) -> Result<f64, SessionEnd> {
        let usual = if letter.is_rotary() { PI / 180.0 } else { 1.0 };
        let properties = self.children(node).await?;
        let Some((_, units)) = properties.iter().find(|(name, _)| name == "EngineeringUnits") else {
            return Ok(usual);
        };
        let values = self.values(std::slice::from_ref(units)).await?;
        let Some((_, Some(Variant::ExtensionObject(object)))) = values.first() else { return Ok(usual) };
        let Some(information) = object.inner_as::<EUInformation>() else { return Ok(usual) };
        // The id is the code's letters as bytes of one number (OPC 10000-8 §5.6.3.4).
        let code: String =
            information.unit_id.to_be_bytes().into_iter().filter(|byte| *byte != 0).map(char::from).collect();
        match (code.as_str(), letter.is_rotary()) {
            ("MMT", false) => Ok(1.0),
            ("MTR", false) => Ok(1000.0),
            ("INH", false) => Ok(25.4),
            ("DD", true) => Ok(PI / 180.0),
            ("C81", true) => Ok(1.0),
            _ => Err(SessionEnd::WrongDevice {
                found: format!(
                    "axis {letter} in the unit {} ({code})",
                    information.display_name.text.as_ref()
                ),
                expected: if letter.is_rotary() { "degrees or radians" } else { "mm, m or inch" }.into(),
            }),
        }
    }
}
