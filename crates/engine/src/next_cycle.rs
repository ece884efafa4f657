//! What to measure next: the cycle that separates rival effects, per minute of machine time (docs/design/statistics.md §6).
//!
//! Rivals are effects that the data leave confounded, or that the present cycle cannot see at all. Candidate cycles are made
//! from the machine and the present setups (`candidates`); for each the states it visits, the columns of rivals and model there
//! together with the present data (same location errors, ball mounted again), whitened under a few noise models (`information`),
//! and from these the expected ln Bayes factor of every two rivals: T-optimality (`separation`). Cycles that separate every pair
//! come first, then those that separate the first rival from most others, then those that separate the pairs farthest on
//! average, per minute.
//! Limits: linear in small errors; the noise stays what it is; nothing is charged for the number of parameters.

mod advice;
mod again;
mod answer;
mod candidates;
mod choose;
mod consideration;
mod design;
mod information;
mod knowledge;
mod options;
mod planned;
mod present;
mod preview;
mod rivals;
mod separation;
mod utility;

pub use advice::{advise, next};
pub use answer::{Considered, LeftOpen, Plan};
pub use choose::{plan, plan_problem};
pub use options::{Options, PlanError};
pub use planned::{Goal, PlannedCycle};
pub use preview::{Alias, Preview, preview};
pub use rivals::{Rivals, rivals_named};
