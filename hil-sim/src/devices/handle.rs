//! What the outside holds of a running device.

use super::faults::Fault;
use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

/// Where a device is reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// Symbolic link to the pseudo-terminal; the link keeps its name when the device is plugged in again.
    Port(PathBuf),
    /// Base URL of the agent or server, without a slash at the end.
    Url(String),
    /// Host and port of a server on TCP.
    Tcp(SocketAddr),
}

impl Address {
    /// The address on TCP, where there is one.
    pub(super) fn socket(&self) -> Option<SocketAddr> {
        match self {
            Address::Port(_) => None,
            Address::Url(url) => url.split_once("//")?.1.parse().ok(),
            Address::Tcp(address) => Some(*address),
        }
    }

    /// The same service at another address on TCP.
    pub(super) fn at(&self, address: SocketAddr) -> Self {
        match self {
            Address::Url(url) => {
                Address::Url(format!("{}//{address}", url.split_once("//").map_or("", |(scheme, _)| scheme)))
            }
            Address::Port(_) | Address::Tcp(_) => Address::Tcp(address),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Address::Port(path) => path.display().fmt(f),
            Address::Url(url) => url.fmt(f),
            Address::Tcp(address) => address.fmt(f),
        }
    }
}

/// Why a device could not be started.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// No pseudo-terminal, or no link to it.
    #[error("no pseudo-terminal for {path}")]
    Port {
        /// The link.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The address cannot be listened on.
    #[error("cannot listen on {address}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
    /// A setting that no device has.
    #[error("{device}: {setting} = {found}; allowed is {allowed}")]
    Setting {
        /// Which device.
        device: &'static str,
        /// Which setting.
        setting: &'static str,
        /// Its value.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A fault this kind of device cannot have, or one with an impossible duration.
    #[error("{device} cannot have the fault {fault:?}")]
    Fault {
        /// Which device.
        device: &'static str,
        /// The fault.
        fault: Fault,
    },
}

/// Why a fault was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum InjectError {
    /// This kind of device cannot have it, or its duration is impossible.
    #[error("this device cannot have the fault {0:?}")]
    NotPossible(Fault),
    /// Too many faults are waiting.
    #[error("the device has {FAULT_QUEUE} faults waiting already")]
    TooMany,
    /// The device has been shut down.
    #[error("the device has been shut down")]
    Stopped,
}

/// Faults that can wait for a device.
pub(super) const FAULT_QUEUE: usize = 16;

/// A running device. Dropping the handle switches the device off; [`Handle::shutdown`] waits until it is off.
#[derive(Debug)]
pub struct Handle {
    address: Address,
    faults: mpsc::Sender<Fault>,
    can_have: fn(&Fault) -> bool,
    lost_bytes: Arc<AtomicU64>,
    latest_us: Arc<AtomicU64>,
    stop: CancellationToken,
    task: JoinHandle<()>,
    /// The device that this is the network of.
    behind: Option<Box<Handle>>,
}

impl Handle {
    pub(super) fn new(
        address: Address,
        (faults, can_have): (mpsc::Sender<Fault>, fn(&Fault) -> bool),
        lost_bytes: Arc<AtomicU64>,
        stop: CancellationToken,
        task: JoinHandle<()>,
    ) -> Self {
        Self { address, faults, can_have, lost_bytes, latest_us: Arc::default(), stop, task, behind: None }
    }

    /// With what the device notes of how late it was, µs.
    pub(super) fn noting(mut self, latest_us: Arc<AtomicU64>) -> Self {
        self.latest_us = latest_us;
        self
    }

    pub(super) fn in_front_of(mut self, device: Handle) -> Self {
        self.behind = Some(Box::new(device));
        self
    }

    /// Where the device is reached.
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// The port of a serial device.
    pub fn port(&self) -> Option<&Path> {
        match &self.address {
            Address::Port(path) => Some(path),
            Address::Url(_) | Address::Tcp(_) => None,
        }
    }

    /// The base URL of an agent.
    pub fn url(&self) -> Option<&str> {
        match &self.address {
            Address::Port(_) | Address::Tcp(_) => None,
            Address::Url(url) => Some(url),
        }
    }

    /// Gives the device a fault; it happens at once. A network in front of it is what is unplugged, freezes, and has
    /// what the device cannot have itself.
    pub fn inject(&self, fault: Fault) -> Result<(), InjectError> {
        let device = self.behind.as_ref().filter(|device| (device.can_have)(&fault));
        if let Some(device) = device.filter(|_| !matches!(fault, Fault::Unplug { .. })) {
            return device.inject(fault);
        }
        if !(self.can_have)(&fault) {
            return Err(InjectError::NotPossible(fault));
        }
        self.faults.try_send(fault).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => InjectError::TooMany,
            mpsc::error::TrySendError::Closed(_) => InjectError::Stopped,
        })
    }

    /// Bytes the device sent that nobody read in time, or that a fault swallowed.
    pub fn lost_bytes(&self) -> u64 {
        self.lost_bytes.load(Ordering::Relaxed)
    }

    /// How late a serial device was at most with what it sends on its own: the computer was busy, which no device on a bench is.
    pub fn latest(&self) -> Duration {
        Duration::from_micros(self.latest_us.load(Ordering::Relaxed))
    }

    /// Switches the device off and waits until its port is gone.
    pub async fn shutdown(mut self) {
        self.stop.cancel();
        if let Err(error) = (&mut self.task).await {
            tracing::error!(%error, address = %self.address, "the device ended badly");
        }
        if let Some(device) = self.behind.take() {
            Box::pin(device.shutdown()).await;
        }
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}
