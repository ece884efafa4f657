//! Frames of devices that are none of ours, as many as a bus of 1 Mbit/s carries.

use anyhow::Context;
use socketcan::{CanFrame, CanSocket, EmbeddedFrame, Socket, StandardId};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Frames of eight bytes at 1 Mbit/s, 1/ms: a standard frame has 47 bits around its 64, without stuff bits.
const FRAMES_PER_MS: u32 = 9;
/// An identifier of no CANopen service of our nodes: TPDO 4 of node 100.
const ID: u16 = 0x480 + 100;

/// A sending thread.
pub struct Flood {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<anyhow::Result<u64>>,
}

impl Flood {
    /// Sends for so long.
    pub fn start(socket: CanSocket, length: Duration) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let id = StandardId::new(ID).context("11 bits")?;
            let frame = CanFrame::new(id, &[0x5A; 8]).context("eight bytes")?;
            let (begun, mut sent) = (Instant::now(), 0);
            while begun.elapsed() < length && !stopped.load(Ordering::Relaxed) {
                let due = u64::from(FRAMES_PER_MS) * begun.elapsed().as_millis() as u64;
                while sent < due {
                    socket.write_frame_insist(&frame).context("sending")?;
                    sent += 1;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(sent)
        });
        Self { stop, thread }
    }

    /// Waits for its end; how many frames it sent.
    pub fn join(self) -> anyhow::Result<u64> {
        self.thread.join().map_err(|_| anyhow::anyhow!("the flood panicked"))?
    }

    /// Ends it before.
    pub fn stop(self) -> anyhow::Result<u64> {
        self.stop.store(true, Ordering::Relaxed);
        self.join()
    }
}
