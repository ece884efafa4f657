//! Quantities, joints, states, twists, time stamps, the nouns of a run, and the one reader of hand-written files.
//!
//! Inside the program every length is in mm, every angle in rad, every time in s, every temperature
//! difference in K. Files and screens use mm, µm, degrees, µrad and °C; [`convert`] is the only place
//! where one becomes the other. Everything here is plain data; nothing opens a file or asks a clock.

mod artefact;
pub mod axis;
mod calibration;
mod chain;
pub mod channel;
pub mod convert;
mod day;
pub mod direction;
pub mod input;
mod kind;
pub mod names;
pub mod number;
mod point;
pub mod problem;
pub mod reading;
mod renamed;
mod sample;
pub mod secret;
pub mod setup;
mod spans;
mod state;
pub mod statistics;
pub mod time;
mod twist;

pub use artefact::{Artefact, Target};
pub use axis::{AxisValues, Joint, JointError, Slot};
pub use calibration::{Calibration, read_calibrations};
pub use chain::chain;
pub use channel::{Channel, Role};
pub use day::Day;
pub use kind::{InstrumentKind, ReadingColumn};
pub use point::{Lacks, Point, Quality};
pub use problem::{Problem, Problems};
pub use renamed::{Part, Renamed};
pub use sample::{AxisSample, Event, Gap, ProbeSample, Stamp};
pub use secret::Secret;
pub use setup::{NestSide, Setup};
pub use state::State;
pub use time::{Clock, HostTime};
pub use twist::{LEVER_MM, Twist};
