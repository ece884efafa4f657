//! A machine tool that exists only in the computer, keeps the truth about itself, and speaks through real ports.
//!
//! [`physics`] gives its errors (own transforms, own error physics: nothing here is shared with the columns of
//! a fit), [`truth`] says what is wrong with it and seals that in a file the program never reads, [`motion`]
//! moves it, [`compensation`] corrects it as a controller would, [`devices`] speak the real protocols.

pub mod attempts;
pub mod compensation;
pub mod devices;
mod instruments;
pub mod motion;
pub mod pauses;
pub mod physics;
pub mod replies;
pub mod scenario;
pub mod truth;

pub use compensation::Compensation;
pub use physics::hidden::HiddenChoice;
pub use physics::{Sampler, VirtualMachine};
pub use truth::{Instrument, NestOn, SimForm, SimSetup, SimTarget, Truth};
