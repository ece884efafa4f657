//! The nouns of a run: setup, cycle, point, sample, event, gap.
//!
//! A [`Run`] is what identification works on, whether it was measured live, replayed or imported.
//! Everything here is plain data; nothing opens a file or asks a clock.

mod artefact;
pub mod blocks;
pub mod cycle;
pub mod direction;
mod kind;
mod point;
mod run;
mod sample;
pub mod setup;
pub mod time_quality;

pub use artefact::{Artefact, Target};
pub use cycle::Cycle;
pub use kind::{InstrumentKind, ReadingColumn};
pub use point::{Point, Quality};
pub use run::{Run, RunKind};
pub use sample::{AxisSample, Event, Gap, ProbeSample, Stamp};
pub use setup::{NestSide, Setup};
