//! What the page is given.

use super::runs::Runs;
use crate::mqtt::Board;
use std::sync::Arc;
use trunnion::results::{CycleGrid, Serves};
use trunnion_core::Clock;

/// What the page shows.
pub struct Shared {
    /// What is behind the page.
    pub serves: Serves,
    /// Name of the machine tool or of the recording.
    pub name: String,
    /// The recordings.
    pub runs: Arc<Runs>,
    /// What the service publishes.
    pub board: Board,
    /// The cycle that is measured here.
    pub cycle: Option<CycleGrid>,
    /// For the dates of what is added.
    pub clock: Arc<dyn Clock>,
}
