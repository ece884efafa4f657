//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod damage;
mod full_disk;
mod kill;
mod on_the_fly;
mod points;
mod round_trip;
mod schema;
