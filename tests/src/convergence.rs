//! Whether fits converge: every shipped cycle on machines, mountings and position scatter drawn at random.
//!
//! A trial measures one cycle twice on one machine: at the commanded positions, and with every axis off them by the scatter, as
//! encoders report them. Micrometres of scatter must change neither what is observable nor any number beyond its uncertainty.

mod trial;

pub use trial::{CASES, Case, Failure, fit_without_scatter, trial};
