//! Machines: a chain of joints from the table down to the bed and from the bed up to the tool; three of the tool's may be legs
//! in parallel ([`tripod`], S3).
//!
//! Every joint carries an error twist before its motion, `T_k = D(errors)·Motion(q)` (docs/design/physics.md §2,
//! S1 eq. 6–7). [`kinematics`] multiplies the transforms exactly; [`propagation`] gives the same to
//! first order, which is what the columns of a fit are made of.

mod chain;
mod file;
pub mod kinematics;
mod plate;
pub mod propagation;
mod reach;
pub mod shipped;
mod site;
pub mod tripod;

pub use chain::{Axis, AxisFacts, Machine, Side};
pub use file::QUANTITY_PREFIXES;
pub use kinematics::{JointErrors, Link};
pub use plate::{NamePlate, TOLERANCE_UM};
pub use site::{Errors, MOST_INNER, Site};
pub use tripod::{Leg, Tripod};
