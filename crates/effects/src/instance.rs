//! An effect placed on a subject: what a model lists and a diagnosis scores.

use crate::catalogue::REGISTRY;
use crate::{Effect, Emit, Parameter, Scene, Shapes, Subject};
use trunnion_machine::{Machine, State};
use trunnion_units::AxisLetter;

/// One effect on one subject, e.g. `gravity-sag:B`.
#[derive(Clone, Copy)]
pub struct Instance {
    /// The effect.
    pub effect: &'static Effect,
    /// Its subject.
    pub subject: Subject,
}

/// An id that names no effect of this machine.
#[derive(Clone, Debug, thiserror::Error)]
#[error("there is no effect \"{id}\" on machine {machine}; allowed: {allowed}")]
pub struct UnknownEffect {
    /// What was asked for.
    pub id: String,
    /// On which machine.
    pub machine: String,
    /// Ids this machine can have.
    pub allowed: String,
}

impl Instance {
    /// Every instance this machine can have, in registry order.
    pub fn all(machine: &Machine) -> Vec<Self> {
        REGISTRY
            .iter()
            .flat_map(|effect| (effect.subjects)(machine).into_iter().map(|subject| Self { effect, subject }))
            .collect()
    }

    /// The instance with this id.
    ///
    /// # Errors
    /// When the machine has no such effect; lists what is allowed.
    pub fn find(id: &str, machine: &Machine) -> Result<Self, UnknownEffect> {
        let all = Self::all(machine);
        all.iter().find(|instance| instance.id() == id).copied().ok_or_else(|| UnknownEffect {
            id: id.into(),
            machine: machine.name.clone(),
            allowed: all.iter().map(Self::id).collect::<Vec<_>>().join(", "),
        })
    }

    /// `phenomenon` or `phenomenon:SUBJECT`.
    pub fn id(&self) -> String {
        let phenomenon = self.effect.phenomenon;
        match self.subject {
            Subject::Whole => phenomenon.into(),
            Subject::Axis(letter) => format!("{phenomenon}:{letter}"),
            Subject::Pair(first, second) => format!("{phenomenon}:{first}{second}"),
        }
    }

    /// Linear parameters in this scene; empty when out of reach.
    pub fn parameters(&self, scene: &Scene) -> Vec<Parameter> {
        (self.effect.parameters)(scene, self.subject)
    }

    /// Grid of shape numbers in this scene.
    pub fn shapes(&self, scene: &Scene) -> Shapes {
        (self.effect.shapes)(scene, self.subject)
    }

    /// Motions per unit parameter.
    pub fn motions(&self, scene: &Scene, shape: &[f64], state: &State, emit: Emit<'_>) {
        (self.effect.motions)(scene, self.subject, shape, state, emit);
    }
}

/// One subject for every rotary axis of the machine.
pub fn every_rotary(machine: &Machine) -> Vec<Subject> {
    machine.rotary().iter().map(|axis| Subject::Axis(axis.letter)).collect()
}

/// One subject for every linear axis of the machine.
pub fn every_linear(machine: &Machine) -> Vec<Subject> {
    AxisLetter::LINEAR.into_iter().filter(|&l| machine.axis(l).is_some()).map(Subject::Axis).collect()
}

/// One subject for every axis of the machine.
pub fn every_axis(machine: &Machine) -> Vec<Subject> {
    machine.axes().map(|axis| Subject::Axis(axis.letter)).collect()
}
