//! Setups of a cycle as the virtual machine mounts them.

use super::setup::{Instrument, NestOn, SimForm, SimSetup, SimTarget};
use trunnion_core::{Artefact, InstrumentKind, NestSide, Setup};

impl From<&Setup> for SimSetup {
    fn from(setup: &Setup) -> Self {
        let nest = match setup.nest {
            NestSide::Table => NestOn::Table,
            NestSide::Spindle => NestOn::Spindle,
        };
        let targets = setup.artefact.as_ref().map_or_else(Vec::new, |artefact| targets(setup, artefact));
        let plate = setup.instrument == InstrumentKind::BallPlate;
        Self {
            ball_in_tool_mm: setup.ball_in_tool_mm,
            targets,
            uncalibrated: setup.artefact.as_ref().filter(|_| !setup.calibrated && plate).map(|artefact| {
                SimForm { name: artefact.name.clone(), table_from_artefact: artefact.table_from_artefact() }
            }),
            ..Self::new(&setup.name, nest, setup.ball_in_table_mm, instrument(setup))
        }
    }
}

/// The kind, with what a setup of it must hold: a key that it does not need makes it no other instrument.
fn instrument(setup: &Setup) -> Instrument {
    let kind = setup.instrument;
    let plain = Instrument::new(kind);
    let length_mm = setup.bar_length_mm.filter(|_| kind.keeps_bar_length());
    let direction = setup.direction.filter(|_| kind.has_direction());
    Instrument {
        length_mm: length_mm.unwrap_or(plain.length_mm),
        arms_mm: setup.arms_mm.filter(|_| kind.has_arms()).unwrap_or(plain.arms_mm),
        direction: direction.map_or(plain.direction, |along| along.into_inner()),
        ..plain
    }
}

fn targets(setup: &Setup, artefact: &Artefact) -> Vec<SimTarget> {
    let target = |k: usize| SimTarget {
        in_table_mm: setup.target_in_table_mm(k),
        normal: artefact.normal_in_table(k).map_or([0.0; 3], |normal| normal.into_inner().into()).into(),
    };
    (0..artefact.targets.len()).map(target).collect()
}
