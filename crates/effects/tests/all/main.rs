//! The integration tests of this crate, one file per subject.

mod catalogue;
mod distinct;
mod golden;
mod motions;
mod reach;
mod scenes;
