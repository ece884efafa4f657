//! The integration tests of this crate, one file per subject.

mod hybrid;
mod joints;
mod links;
