//! The catalogue of physical effects.
//!
//! An effect is a small twist at a joint (or an offset of ball, nest or probe) as a function of the machine's
//! state, linear in a few parameters and, for some, of a few shape numbers (a time constant, a number of teeth) that are searched on a grid.
//! One file per effect in [`catalogue`], one line in its registry.

pub mod catalogue;
mod effect;
pub mod formula;
mod golden;
mod history;
mod instance;
mod legendre;
mod markdown;
pub mod model;
mod need;
mod path;
mod picture;
mod reading;
mod scene;
mod subjects;

pub use effect::{About, Effect, Emit, Example, Parameter, Role, Shapes, Subject, Unit, View};
pub use formula::{Formula, FormulaError};
pub use golden::{ByAxis, Checked, Golden, Moment};
pub use history::History;
pub use instance::{Instance, UnknownEffect};
pub use markdown::{SOURCES, catalogue_markdown};
pub use model::{LadderRow, Model, ModelEffect, Moved, Prior};
pub use need::Need;
pub use path::Path;
pub use picture::{Picture, catalogue_pictures};
pub use reading::r_test_reading;
pub use scene::{PLACES_OF_A_VOLUME, Scene, SceneArtefact, SceneSetting, SceneSetup};
pub use subjects::{every_axis, every_linear, every_rotary};
