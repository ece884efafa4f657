//! The page: recordings, what was found in them, and what is measured, for a browser (docs/use/page.md).
//!
//! Who may call what is decided in [`guard`], connections are counted in `accept`, recordings are found and analysed in
//! [`runs`]. A page that is attacked slows no sample: one analysis at a time, and nothing here waits for a device.

mod accept;
mod answer;
mod assets;
mod calls;
mod grid;
mod guard;
mod live;
mod runs;

pub use accept::serve;
pub use grid::grid_of;
pub use runs::Runs;

use crate::mqtt::Board;
use std::net::SocketAddr;
use std::sync::Arc;
use trunnion::results::{CycleGrid, Serves};
use trunnion_core::Clock;

/// Where the page listens without a word in the configuration.
pub const USUAL_ADDRESS: &str = "127.0.0.1:8460";

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

/// Why an address is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// No address.
    #[error("\"{0}\" is no address")]
    NoAddress(String),
    /// An address that others reach.
    #[error("{0} can be reached from other computers, and the page has neither a token nor TLS yet")]
    NotThisComputer(SocketAddr),
}

/// An address to listen on: of this computer only.
///
/// # Errors
/// No address, or one that other computers reach.
pub fn address(text: &str) -> Result<SocketAddr, AddressError> {
    let address: SocketAddr = text.parse().map_err(|_| AddressError::NoAddress(text.into()))?;
    if address.ip().is_loopback() { Ok(address) } else { Err(AddressError::NotThisComputer(address)) }
}
