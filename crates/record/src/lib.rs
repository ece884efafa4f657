//! Recordings: one run is one MCAP file (docs/design/contracts.md §8).
//!
//! While a run is recorded, [`Recorder`] writes an unchunked journal `NAME.mcap.active`, one system call a
//! message, so that a kill loses nothing that was written. [`Recorder::finish`] rewrites it sorted by
//! acquisition time, chunked, compressed and indexed, reads it back and only then renames it.
//! [`recover_orphans`] does the same for journals left behind. [`read_run`] and [`visit`] read any of them,
//! damaged or not; [`visit_points`] reads the points alone, however many there are. [`points_csv`] and [`export`] are the ways in and out as tables.

pub mod b5r;
mod column;
mod container;
mod contents;
mod damage;
mod error;
pub mod export;
mod finish;
pub mod foxglove;
mod handle;
mod item;
mod journal;
mod journal_file;
mod lossless;
mod lost;
mod motion;
mod near;
pub mod points_csv;
mod reader;
mod rows;
mod schema;
mod scrub;
mod syncs;
mod verify;
mod whole_run;
mod wire;
mod writer;

pub use damage::Damage;
pub use error::RecordError;
pub use finish::{FinishedFile, Orphan, recover_orphans};
pub use handle::{RecordSender, RecorderHandle, RecorderStatus};
pub use item::{Item, RunHeader, Temperature};
pub use journal_file::{JOURNAL_ENDING, is_journal, sync_folder};
pub use near::with_nearest;
pub use reader::{
    OnPoint, Recording, RunStart, read_header, read_run, read_run_of_bytes, visit, visit_points,
    visit_samples,
};
pub use schema::FILE_DESCRIPTOR_SET;
pub use scrub::{Scrubbed, scrub};
pub use whole_run::{RunWriter, write_run, write_run_with_axes};
pub use writer::{BATCH_AGE, Finished, Recorder};
