//! Setups as protobuf messages and back.

use crate::schema as pb;
use nalgebra::{Point3, Unit, Vector3};
use trunnion_core::{Artefact, InstrumentKind, NestSide, Setup, Target};

pub(super) fn encode(setup: &Setup) -> pb::Setup {
    pb::Setup {
        name: setup.name.clone(),
        instrument: setup.instrument.name().into(),
        nest: match setup.nest {
            NestSide::Table => "table".into(),
            NestSide::Spindle => "spindle".into(),
        },
        ball_in_table_mm: setup.ball_in_table_mm.coords.as_slice().to_vec(),
        bar_length_mm: setup.bar_length_mm,
        ball_in_tool_mm: setup.ball_in_tool_mm.coords.as_slice().to_vec(),
        direction: setup.direction.map_or_else(Vec::new, |along| along.as_slice().to_vec()),
        arms_mm: setup.arms_mm.map_or_else(Vec::new, Vec::from),
        calibrated: setup.calibrated,
        artefact: setup.artefact.as_ref().map(|artefact| pb::Artefact {
            name: artefact.name.clone(),
            turned_rad: artefact.turned_rad.as_slice().to_vec(),
            targets: artefact.targets.iter().map(encode_target).collect(),
        }),
    }
}

fn encode_target(target: &Target) -> pb::Target {
    pb::Target {
        name: target.name.clone(),
        at_mm: target.at_mm.as_slice().to_vec(),
        normal: target.normal.map_or_else(Vec::new, |normal| normal.as_slice().to_vec()),
    }
}

/// `None` when the message contradicts itself.
pub(super) fn decode(setup: pb::Setup) -> Option<Setup> {
    let instrument = InstrumentKind::NAMES.into_iter().find(|(name, _)| *name == setup.instrument)?.1;
    let nest = match setup.nest.as_str() {
        "table" => NestSide::Table,
        "spindle" => NestSide::Spindle,
        _ => return None,
    };
    let arms_mm = match setup.arms_mm[..] {
        [] => None,
        [first, second] => Some([first, second]),
        _ => return None,
    };
    let artefact = match setup.artefact {
        None => None,
        Some(artefact) => Some(Artefact {
            name: artefact.name,
            turned_rad: Vector3::from(three(&artefact.turned_rad)?),
            targets: artefact.targets.into_iter().map(decode_target).collect::<Option<_>>()?,
        }),
    };
    // Recordings from before other places in the tool were known have none.
    let ball_in_tool =
        if setup.ball_in_tool_mm.is_empty() { [0.0; 3] } else { three(&setup.ball_in_tool_mm)? };
    Some(Setup {
        bar_length_mm: setup.bar_length_mm,
        ball_in_tool_mm: Point3::from(ball_in_tool),
        direction: direction(&setup.direction)?,
        arms_mm,
        calibrated: setup.calibrated,
        artefact,
        ..Setup::new(setup.name, instrument, nest, Point3::from(three(&setup.ball_in_table_mm)?))
    })
}

fn decode_target(target: pb::Target) -> Option<Target> {
    let at_mm = Vector3::from(three(&target.at_mm)?);
    Some(Target { name: target.name, at_mm, normal: direction(&target.normal)? })
}

/// An empty list is no direction; as written, without making it a unit again.
fn direction(list: &[f64]) -> Option<Option<Unit<Vector3<f64>>>> {
    if list.is_empty() {
        return Some(None);
    }
    let vector = Vector3::from(three(list)?);
    ((vector.norm() - 1.0).abs() < 1e-9).then(|| Some(Unit::new_unchecked(vector)))
}

pub(super) fn three(list: &[f64]) -> Option<[f64; 3]> {
    <[f64; 3]>::try_from(list).ok()
}
