//! The integration tests of this crate, one file per subject.

mod catalogue;
mod distinct;
mod golden;
mod motions;
mod places;
mod reach;
mod scenes;
