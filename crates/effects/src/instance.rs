//! An effect placed on a subject: what a model lists and a diagnosis scores.

use crate::catalogue::{BASE, REGISTRY};
use crate::formula::{Formula, FormulaError};
use crate::{About, Effect, Emit, ModelEffect, Need, Parameter, Role, Scene, Shapes, Subject};
use std::fmt;
use std::sync::Arc;
use trunnion_core::{State, names};
use trunnion_machine::Machine;

/// One effect on one subject, e.g. `gravity-sag:B`, or a formula out of a model file.
#[derive(Clone)]
pub enum Instance {
    /// An effect of the catalogue.
    Catalogue {
        /// The effect.
        effect: &'static Effect,
        /// Its subject.
        subject: Subject,
    },
    /// A `formula:NAME` effect.
    Formula(Arc<Formula>),
}

/// A model entry that is no effect of this machine.
#[derive(Clone, Debug, thiserror::Error)]
pub enum UnknownEffect {
    /// No such id.
    #[error(
        "there is no effect \"{id}\" on machine {machine}; allowed: {allowed}, formula:NAME in a model file"
    )]
    Id {
        /// What was asked for.
        id: String,
        /// On which machine.
        machine: String,
        /// Ids this machine can have.
        allowed: String,
    },
    /// A formula that cannot be read.
    #[error("{id} cannot be read")]
    Formula {
        /// Id of the formula.
        id: String,
        /// Why.
        #[source]
        error: FormulaError,
    },
}

impl Instance {
    /// Every catalogue instance this machine can have, in registry order.
    pub fn all(machine: &Machine) -> Vec<Self> {
        REGISTRY
            .iter()
            .copied()
            .flat_map(|effect| {
                (effect.subjects)(machine).into_iter().map(move |subject| Self::Catalogue { effect, subject })
            })
            .collect()
    }

    /// The catalogue instance with this id.
    ///
    /// # Errors
    /// When the machine has no such effect; lists what is allowed.
    pub fn find(id: &str, machine: &Machine) -> Result<Self, UnknownEffect> {
        let all = Self::all(machine);
        all.iter().find(|instance| instance.id() == id).cloned().ok_or_else(|| UnknownEffect::Id {
            id: id.into(),
            machine: machine.name.clone(),
            allowed: names::allowed(id, all.iter().map(Self::id)),
        })
    }

    /// The instance an entry of a model names; a `formula:NAME` is read from the entry.
    ///
    /// # Errors
    /// When the machine has no such effect, or the formula cannot be read.
    pub fn from_model_effect(entry: &ModelEffect, machine: &Machine) -> Result<Self, UnknownEffect> {
        if Formula::name_of(&entry.id).is_none() {
            return Self::find(&entry.id, machine);
        }
        let formula = Formula::from_model_effect(entry, machine)
            .map_err(|error| UnknownEffect::Formula { id: entry.id.clone(), error })?;
        Ok(Self::Formula(Arc::new(formula)))
    }

    /// `phenomenon`, `phenomenon:SUBJECT` or `formula:NAME`.
    pub fn id(&self) -> String {
        match self {
            Self::Formula(formula) => Formula::id_of(&formula.name),
            Self::Catalogue { effect, subject } => match subject {
                Subject::Whole => effect.phenomenon.into(),
                Subject::Axis(letter) => format!("{}:{letter}", effect.phenomenon),
                Subject::Pair(first, second) => format!("{}:{first}{second}", effect.phenomenon),
            },
        }
    }

    /// What a person should know of it; a formula has nothing but its expression.
    pub fn about(&self) -> Option<&'static About> {
        match self {
            Self::Catalogue { effect, .. } => Some(&effect.about),
            Self::Formula(_) => None,
        }
    }

    /// What kind of thing it is; an expression describes and names no cause.
    pub fn role(&self) -> Role {
        match self {
            Self::Catalogue { effect, .. } => effect.role,
            Self::Formula(_) => Role::Description,
        }
    }

    /// True when every model has it.
    pub fn is_base(&self) -> bool {
        matches!(self, Self::Catalogue { effect, .. } if BASE.contains(&effect.phenomenon))
    }

    /// What it is about; a formula belongs to its site only.
    pub fn subject(&self) -> Subject {
        match self {
            Self::Catalogue { subject, .. } => *subject,
            Self::Formula(_) => Subject::Whole,
        }
    }

    /// Linear parameters in this scene; empty when out of reach.
    pub fn parameters(&self, scene: &Scene) -> Vec<Parameter> {
        match self {
            Self::Catalogue { effect, subject } => (effect.parameters)(scene, *subject),
            Self::Formula(formula) => formula.parameters(scene),
        }
    }

    /// What the data lack for this effect to show; not empty exactly when a catalogue effect is out of reach.
    pub fn missing(&self, scene: &Scene) -> Vec<Need> {
        let lacks = |need: &Need| need.met(scene, self.subject()) == Some(false);
        self.about().map_or(&[][..], |about| about.needs).iter().copied().filter(lacks).collect()
    }

    /// Why the effect is out of reach in this scene, in words; `None` when it is within reach.
    pub fn out_of_reach(&self, scene: &Scene) -> Option<String> {
        if let Self::Formula(formula) = self {
            return formula.out_of_reach(scene);
        }
        let missing: Vec<&str> = self.missing(scene).into_iter().map(Need::text).collect();
        (!missing.is_empty()).then(|| format!("needs {}", missing.join("; ")))
    }

    /// What this scene lacks for a parameter that the effect had in another, in words; `None` where the parameter is here, where the whole
    /// effect is out of reach, and where what the parameter acts on stays zero.
    pub fn lacks(&self, scene: &Scene, parameter: &str) -> Option<String> {
        let here = self.parameters(scene);
        let known = here.iter().any(|own| own.name == parameter)
            || self.shapes(scene).names.iter().any(|name| name == parameter);
        let needs = self.about().map_or(&[][..], |about| about.needs);
        if here.is_empty() || known || needs.iter().any(|need| need.is_acted_on()) {
            return None;
        }
        if !needs.contains(&Need::Temperature) {
            return Some(format!("has no {parameter} there: it needs more places of the axis"));
        }
        let channel = parameter.rsplit_once('.').map_or(parameter, |(channel, _)| channel);
        let missing = !scene.channels.iter().any(|known| known == channel);
        missing.then(|| {
            let allowed = names::allowed(channel, &scene.channels);
            format!("needs temperature channel \"{channel}\"; there are {allowed}")
        })
    }

    /// Grid of shape numbers in this scene.
    pub fn shapes(&self, scene: &Scene) -> Shapes {
        match self {
            Self::Catalogue { effect, subject } => (effect.shapes)(scene, *subject),
            Self::Formula(formula) => formula.shapes(),
        }
    }

    /// Motions per unit parameter.
    pub fn motions(&self, scene: &Scene, shape: &[f64], state: &State, emit: Emit<'_>) {
        match self {
            Self::Catalogue { effect, subject } => (effect.motions)(scene, *subject, shape, state, emit),
            Self::Formula(formula) => formula.motions(scene, shape, state, emit),
        }
    }
}

impl fmt::Debug for Instance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Instance({})", self.id())
    }
}
