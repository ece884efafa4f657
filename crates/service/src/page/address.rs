//! Where the page may listen.

use std::net::SocketAddr;

/// Where the page listens without a word in the configuration.
pub const USUAL_ADDRESS: &str = "127.0.0.1:8460";

/// Why an address is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// No address.
    #[error("\"{0}\" is no address")]
    NoAddress(String),
    /// An address that others reach.
    #[error(
        "{0} can be reached from other computers; only the service lets them in, with certificate, key_file and token_file in [page]"
    )]
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
