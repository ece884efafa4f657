//! The catalogue of physical effects.
//!
//! An effect is a small twist at a joint (or an offset of ball, nest or probe) as a function of the machine's
//! state, linear in a few parameters and, for some, of a few shape numbers (a time constant, a number of teeth) that are searched on a grid.
//! One file per effect in [`catalogue`], one line in its registry.

pub mod catalogue;
mod effect;
mod fitted_values;
mod fixed_text;
pub mod formula;
mod golden;
mod golden_check;
mod history;
mod instance;
mod legendre;
mod markdown;
pub mod model;
mod model_effect;
mod need;
mod parameter;
mod path;
mod phasors;
mod picture;
mod reading;
mod removal;
mod scene;
mod scene_setup;
pub mod sources;
mod subjects;

pub use effect::{About, Effect, Example, Role, View};
pub use fitted_values::{FittedRun, FittedValue, FittedValues};
pub use fixed_text::{FixedText, fixed_text};
pub use formula::{Formula, FormulaError};
pub use golden::{ByAxis, Golden, Moment};
pub use golden_check::Checked;
pub use history::History;
pub use instance::{Instance, UnknownEffect};
pub use markdown::catalogue_markdown;
pub use model::Model;
pub use model_effect::{LadderRow, ModelEffect, Moved, Prior};
pub use need::Need;
pub use parameter::{Emit, Limit, Parameter, Shapes, Subject, Unit, WaveNumber};
pub use path::Path;
pub use picture::{Picture, catalogue_pictures};
pub use reading::r_test_reading;
pub use removal::Removal;
pub use scene::{PLACES_OF_A_VOLUME, Scene, same_position};
pub use scene_setup::{SceneArtefact, SceneSetting, SceneSetup};
pub use subjects::{every_axis, every_linear, every_rotary};
