//! What the page is given.

use super::runs::Runs;
use crate::board::Board;
use crate::set_up::SetUp;
use std::sync::Arc;
use trunnion::results::{PageCycle, Serves};
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
    /// The cycles that are measured here.
    pub cycles: Vec<PageCycle>,
    /// Setting up at the machine; `None` where nothing is measured.
    pub set_up: Option<SetUp>,
    /// For the dates of what is added.
    pub clock: Arc<dyn Clock>,
}
