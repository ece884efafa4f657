//! Programs of the virtual machine and the motion they make, a pure function of time.
//!
//! Every virtual device evaluates the same [`Trajectory`] at its own sampling instants, so that differences between
//! devices come from their clocks alone.

mod path;
mod profile;
mod program;
mod trajectory;

pub use program::{Follow, Program, ProgramError, Step};
pub use trajectory::{Kinematics, Trajectory};
