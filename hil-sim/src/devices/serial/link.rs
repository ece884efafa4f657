//! The line between a device and its port, with what can go wrong on it.
//!
//! A real line keeps nothing for a user who is not there. A pseudo-terminal does, so bytes unread for
//! [`UNREAD_S`] are thrown away and counted, as are those the kernel does not take.

use super::pty::Pty;
use crate::devices::faults::{Fault, damage};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// After this time bytes not read count as lost, s; a user of the port is never that slow.
const UNREAD_S: f64 = 1.0;

#[derive(Debug)]
pub(super) struct Link {
    path: PathBuf,
    /// `None` while unplugged.
    pty: Option<Pty>,
    replug_s: f64,
    silent_until_s: f64,
    garble_left: usize,
    /// Since when, and how many bytes, the user may not have read.
    unread: Option<(f64, u64)>,
    sent_bytes: u64,
    lost_bytes: Arc<AtomicU64>,
}

impl Link {
    pub fn plug_in(path: &Path, lost_bytes: Arc<AtomicU64>) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            pty: Some(Pty::open(path)?),
            replug_s: 0.0,
            silent_until_s: f64::NEG_INFINITY,
            garble_left: 0,
            unread: None,
            sent_bytes: 0,
            lost_bytes,
        })
    }

    /// What happens on the line; the device suffers the rest.
    pub fn suffer(&mut self, fault: Fault, now_s: f64) {
        match fault {
            Fault::GarbleBytes { count } => self.garble_left += count,
            Fault::Silence { duration_s } => {
                self.silent_until_s = self.silent_until_s.max(now_s + duration_s);
            }
            Fault::Unplug { duration_s } => {
                self.replug_s = now_s + duration_s;
                self.pty = None;
                self.unread = None;
            }
            _ => {}
        }
    }

    /// When the cable is put back, while it is pulled.
    pub fn replug_s(&self) -> Option<f64> {
        self.pty.is_none().then_some(self.replug_s)
    }

    pub fn replug(&mut self) -> io::Result<()> {
        self.pty = Some(Pty::open(&self.path)?);
        Ok(())
    }

    pub fn is_silent(&self, now_s: f64) -> bool {
        now_s < self.silent_until_s
    }

    /// Bytes from the user; never while unplugged. Cancel safe.
    pub async fn receive(&self, buffer: &mut [u8]) -> io::Result<usize> {
        match &self.pty {
            Some(pty) => pty.read(buffer).await,
            None => std::future::pending().await,
        }
    }

    pub fn send(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() {
            return;
        }
        let silent = self.is_silent(now_s);
        let Some(pty) = self.pty.as_ref().filter(|_| !silent) else {
            return self.lose(bytes.len() as u64);
        };
        let mut garbled = bytes.to_vec();
        damage(&mut garbled, &mut self.garble_left, self.sent_bytes);
        self.sent_bytes += bytes.len() as u64;
        let (written, discarded) = match deliver(pty, &garbled, &mut self.unread, now_s) {
            Ok(counts) => counts,
            Err(error) => {
                tracing::warn!(%error, port = %self.path.display(), "bytes could not be sent");
                (0, 0)
            }
        };
        self.lose(bytes.len() as u64 - written + discarded);
    }

    fn lose(&self, count: u64) {
        self.lost_bytes.fetch_add(count, Ordering::Relaxed);
    }
}

/// Hands bytes to the kernel; gives how many it took and how many older ones were thrown away.
fn deliver(pty: &Pty, bytes: &[u8], unread: &mut Option<(f64, u64)>, now_s: f64) -> io::Result<(u64, u64)> {
    let mut discarded = 0;
    if !pty.has_unread()? {
        *unread = None;
    }
    if let Some((since_s, count)) = *unread
        && now_s - since_s > UNREAD_S
    {
        pty.discard_unread()?;
        discarded = count;
        *unread = None;
    }
    let written = pty.write_now(bytes)? as u64;
    let (since_s, count) = unread.unwrap_or((now_s, 0));
    *unread = Some((since_s, count + written));
    Ok((written, discarded))
}
