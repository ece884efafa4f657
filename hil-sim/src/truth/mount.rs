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

fn instrument(setup: &Setup) -> Instrument {
    let line = |mirror| Instrument::Line {
        direction: setup.direction.map_or([1.0, 0.0, 0.0], |along| along.into_inner().into()).into(),
        mirror,
    };
    match setup.instrument {
        InstrumentKind::RTest => Instrument::RTest,
        InstrumentKind::BallBar => Instrument::BallBar { length_mm: setup.bar_length_mm.unwrap_or_default() },
        InstrumentKind::Tracker | InstrumentKind::LaserBallBar => Instrument::Length,
        InstrumentKind::PassiveArm => Instrument::Arm { arms_mm: setup.arms_mm.unwrap_or([1.0, 1.0]) },
        InstrumentKind::Diagonal => line(false),
        InstrumentKind::StepDiagonal => line(true),
        InstrumentKind::BallPlate | InstrumentKind::TouchProbe => Instrument::Centre,
        InstrumentKind::TouchProbeFace => Instrument::Face,
        InstrumentKind::MachinedSurface => Instrument::Cut,
    }
}

fn targets(setup: &Setup, artefact: &Artefact) -> Vec<SimTarget> {
    let target = |k: usize| SimTarget {
        in_table_mm: setup.target_in_table_mm(k),
        normal: artefact.normal_in_table(k).map_or([0.0; 3], |normal| normal.into_inner().into()).into(),
    };
    (0..artefact.targets.len()).map(target).collect()
}
