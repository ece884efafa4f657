//! Processor time, memory, and the yardstick.

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;
use std::hint::black_box;

/// Processor time of one GFLOP of the yardstick, s.
pub fn yardstick_s() -> f64 {
    const ROWS: usize = 4096;
    const COLUMNS: usize = 64;
    let rows: Vec<[f64; COLUMNS]> =
        (0..ROWS).map(|i| std::array::from_fn(|j| ((i * 31 + j * 17) % 101) as f64 - 50.0)).collect();
    let begun_s = cpu_s();
    let mut flop = 0.0;
    while cpu_s() - begun_s < 0.5 {
        let mut gram = [[0.0; COLUMNS]; COLUMNS];
        for row in black_box(&rows) {
            for (j, of_row) in gram.iter_mut().enumerate() {
                for (sum, x) in of_row[..=j].iter_mut().zip(row) {
                    *sum += row[j] * x;
                }
            }
        }
        black_box(gram);
        flop += (ROWS * COLUMNS * (COLUMNS + 1)) as f64;
    }
    (cpu_s() - begun_s) / flop * 1e9
}

/// Processor time of this process with all its threads (Linux: fields 14 and 15 of `stat`, in ticks of 10 ms), and of the processes that
/// it waited for, s.
pub fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields = stat.rsplit_once(") ").unwrap().1.split_whitespace().skip(11).take(2);
    let own: f64 = fields.map(|ticks| ticks.parse::<f64>().unwrap() / 100.0).sum();
    let others = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap();
    let seconds = |time: TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    own + seconds(others.user_time()) + seconds(others.system_time())
}

/// Largest resident memory of this process, or of one that it waited for, MiB (Linux).
pub fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    let own = line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap();
    own.max(getrusage(UsageWho::RUSAGE_CHILDREN).unwrap().max_rss() as f64) / 1024.0
}
