//! Somebody else on the bus: a socket that only watches SYNC, with the kernel's stamps and its own arrival times.

use anyhow::{Context, ensure};
use socketcan::{CanFilter, CanSocket, Socket, SocketOptions};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// A watching thread.
pub struct Observer {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<anyhow::Result<Vec<(SystemTime, SystemTime)>>>,
}

/// Begins to watch.
pub fn start(interface: &str) -> anyhow::Result<Observer> {
    let socket = CanSocket::open(interface).with_context(|| format!("opening {interface}"))?;
    socket.set_filters(&[CanFilter::new(0x080, 0x7FF)])?;
    socket.set_recv_timestamp(true)?;
    socket.set_read_timeout(Duration::from_millis(50))?;
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let thread = std::thread::spawn(move || {
        let mut seen = Vec::new();
        while !stopped.load(Ordering::Relaxed) {
            match socket.read_frame_with_timestamp() {
                Ok((_, stamp)) => seen.push((stamp, SystemTime::now())),
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error).context("watching SYNC"),
            }
        }
        Ok(seen)
    });
    Ok(Observer { stop, thread })
}

impl Observer {
    /// Ends watching; what was seen, in words. A stamp later than its arrival is an error.
    pub fn stop(self) -> anyhow::Result<String> {
        self.stop.store(true, Ordering::Relaxed);
        let seen = self.thread.join().map_err(|_| anyhow::anyhow!("the observer panicked"))??;
        ensure!(seen.len() > 50, "only {} SYNCs were seen", seen.len());
        let mut delays_us = Vec::new();
        for (stamp, arrival) in &seen {
            let delay = arrival.duration_since(*stamp).context("a stamp is later than its arrival")?;
            delays_us.push(delay.as_secs_f64() * 1e6);
        }
        let by_stamp: Vec<SystemTime> = seen.iter().map(|(stamp, _)| *stamp).collect();
        let by_arrival: Vec<SystemTime> = seen.iter().map(|(_, arrival)| *arrival).collect();
        delays_us.sort_by(f64::total_cmp);
        Ok(format!(
            "{} SYNCs; period scatters by {:.1} µs rms by kernel stamp, {:.1} µs by arrival; arrival after stamp: \
             median {:.1} µs, 99 % {:.1} µs, worst {:.1} µs",
            seen.len(),
            scatter_us(&by_stamp),
            scatter_us(&by_arrival),
            delays_us[delays_us.len() / 2],
            delays_us[delays_us.len() * 99 / 100],
            delays_us[delays_us.len() - 1],
        ))
    }
}

/// Root mean square of the difference of periods from their mean, µs.
fn scatter_us(times: &[SystemTime]) -> f64 {
    let periods: Vec<f64> = times
        .windows(2)
        .map(|pair| pair[1].duration_since(pair[0]).unwrap_or_default().as_secs_f64() * 1e6)
        .collect();
    let mean = periods.iter().sum::<f64>() / periods.len() as f64;
    (periods.iter().map(|period| (period - mean).powi(2)).sum::<f64>() / periods.len() as f64).sqrt()
}
