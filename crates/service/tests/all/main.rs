//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod page;
