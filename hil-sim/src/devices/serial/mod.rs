//! Runs a serial device in real time on a pseudo-terminal, and gives it its faults.

mod link;
mod outbox;
mod pty;

pub use outbox::Outbox;

use super::clock::TimeOrigin;
use super::faults::{Fault, FaultSource, ScheduledFault};
use super::handle::{Address, DeviceError, FAULT_QUEUE, Handle};
use link::Link;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

/// A device at the far end of a serial line. Times are of the cell, s; answers are bytes for the line.
pub trait SerialDevice: Send + 'static {
    /// Takes bytes from the host and gives the answer.
    fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8>;
    /// When the device next has something to say on its own; later than the last `now_s` of [`Self::send_due`].
    fn next_due_s(&self) -> Option<f64>;
    /// What the device says on its own up to now.
    fn send_due(&mut self, now_s: f64) -> Vec<u8>;
    /// The cable is back; what was powered over it restarts.
    fn plugged_in(&mut self);
    /// True for the faults of its own that this kind of device can have, in addition to those of the line.
    fn has(_fault: &Fault) -> bool
    where
        Self: Sized,
    {
        false
    }
    /// A fault of its own begins.
    fn suffer(&mut self, _fault: Fault, _now_s: f64) {}
}

/// Starts a device on a pseudo-terminal that `port` will link to. Must be called within a tokio runtime.
pub fn spawn<D: SerialDevice>(
    name: &'static str,
    device: D,
    port: &Path,
    origin: TimeOrigin,
    scheduled: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    if let Some(bad) = scheduled.iter().find(|scheduled| !can_have::<D>(&scheduled.fault)) {
        return Err(DeviceError::Fault { device: name, fault: bad.fault });
    }
    let lost_bytes = Arc::new(AtomicU64::new(0));
    let link = Link::plug_in(port, Arc::clone(&lost_bytes))
        .map_err(|source| DeviceError::Port { path: port.to_owned(), source })?;
    let (commands, commanded) = mpsc::channel(FAULT_QUEUE);
    let faults = FaultSource::new(origin, scheduled, commanded);
    let stop = CancellationToken::new();
    let latest_us = Arc::new(AtomicU64::new(0));
    let times = Times { origin, latest_us: Arc::clone(&latest_us) };
    let task = tokio::spawn(run(name, device, link, times, faults, stop.clone()));
    let handle =
        Handle::new(Address::Port(port.to_owned()), (commands, can_have::<D>), lost_bytes, stop, task);
    Ok(handle.noting(latest_us))
}

fn can_have<D: SerialDevice>(fault: &Fault) -> bool {
    fault.is_possible() && (fault.is_of_the_line() || D::has(fault))
}

/// Where the times of a device begin, and by how much it was late at most.
struct Times {
    origin: TimeOrigin,
    /// Read through [`Handle::latest`].
    latest_us: Arc<AtomicU64>,
}

async fn run(
    name: &'static str,
    mut device: impl SerialDevice,
    mut link: Link,
    Times { origin, latest_us }: Times,
    mut faults: FaultSource,
    stop: CancellationToken,
) {
    let mut buffer = [0; 1024];
    loop {
        let at = |t_s: Option<f64>| async move {
            match t_s {
                Some(t_s) => tokio::time::sleep_until(origin.instant_of(t_s)).await,
                None => std::future::pending().await,
            }
        };
        let (due_s, replug_s) = (device.next_due_s(), link.replug_s());
        tokio::select! {
            () = stop.cancelled() => return,
            fault = faults.next() => {
                tracing::info!(device = name, ?fault, "fault");
                let now_s = origin.now_s();
                link.suffer(fault, now_s);
                if !fault.is_of_the_line() {
                    device.suffer(fault, now_s);
                }
            }
            () = at(replug_s) => match link.replug() {
                Ok(()) => device.plugged_in(),
                Err(error) => return tracing::error!(device = name, %error, "the port cannot be opened again"),
            },
            received = link.receive(&mut buffer) => match received {
                Ok(count) => {
                    let now_s = origin.now_s();
                    if !link.is_silent(now_s) {
                        let answer = device.receive(&buffer[..count], now_s);
                        link.send(&answer, now_s);
                    }
                }
                Err(error) => return tracing::error!(device = name, %error, "the port failed"),
            },
            () = at(due_s) => {
                let now_s = origin.now_s();
                let late_s = due_s.map_or(0.0, |due_s| now_s - due_s);
                latest_us.fetch_max((1e6 * late_s) as u64, Ordering::Relaxed);
                let bytes = device.send_due(now_s);
                link.send(&bytes, now_s);
            }
        }
    }
}
