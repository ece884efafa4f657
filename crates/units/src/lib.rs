//! Quantities, axis letters, twists, time stamps, and the one reader of hand-written files.
//!
//! Inside the program every length is in mm, every angle in rad, every time in s, every temperature
//! difference in K. Files and screens use mm, µm, degrees, µrad and °C; [`convert`] is the only place
//! where one becomes the other.

pub mod axis;
pub mod convert;
pub mod input;
pub mod problem;
pub mod time;
mod twist;

pub use axis::{AxisLetter, AxisValues};
pub use problem::{Problem, Problems};
pub use time::{Clock, HostTime};
pub use twist::Twist;
