//! Time and memory of a process, from /proc (proc(5)).

use anyhow::Context;
use std::collections::BTreeMap;
use std::fs;
use std::time::Instant;

/// Ticks per second of the times in /proc: USER_HZ, 100 on every Linux.
const TICKS_PER_S: f64 = 100.0;

/// A process as seen once a second.
pub struct Watch {
    process: u32,
    begun: Instant,
    /// What was seen.
    pub samples: Vec<Sample>,
}

/// One look.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Since the first look, s.
    pub at_s: f64,
    /// Processor time so far, user and system, s.
    pub cpu_s: f64,
    /// Memory in use, MiB.
    pub resident_mib: f64,
    /// The most ever in use, MiB.
    pub peak_mib: f64,
    /// Open descriptors.
    pub descriptors: usize,
    /// Threads.
    pub threads: usize,
    /// Processor time so far by name of thread, s.
    pub threads_s: BTreeMap<String, f64>,
}

impl Watch {
    pub fn new(process: u32) -> Self {
        Self { process, begun: Instant::now(), samples: Vec::new() }
    }

    /// Looks once more.
    pub fn sample(&mut self) -> anyhow::Result<()> {
        let folder = format!("/proc/{}", self.process);
        if self.samples.is_empty() {
            self.begun = Instant::now();
        }
        let read = |path: String| fs::read_to_string(&path).with_context(|| format!("cannot read {path}"));
        let (_, cpu_s) = times(&read(format!("{folder}/stat"))?).context("/proc/…/stat has no times")?;
        let status = read(format!("{folder}/status"))?;
        let descriptors = fs::read_dir(format!("{folder}/fd"))?.count();
        let threads = fs::read_dir(format!("{folder}/task"))?.count();
        let mut threads_s = BTreeMap::new();
        for task in fs::read_dir(format!("{folder}/task"))? {
            // A thread may end between listing and reading.
            let Ok(text) = fs::read_to_string(task?.path().join("stat")) else { continue };
            let Some((name, seconds)) = times(&text) else { continue };
            *threads_s.entry(name).or_insert(0.0) += seconds;
        }
        let mib = |key| kib(&status, key).map(|kib| kib / 1024.0).context("/proc/…/status has no memory");
        self.samples.push(Sample {
            at_s: self.begun.elapsed().as_secs_f64(),
            cpu_s,
            resident_mib: mib("VmRSS:")?,
            peak_mib: mib("VmHWM:")?,
            descriptors,
            threads,
            threads_s,
        });
        Ok(())
    }

    /// Most memory that one of its children ever used, MiB; 0 without children.
    pub fn children_mib(&self) -> f64 {
        let tasks = fs::read_dir(format!("/proc/{}/task", self.process)).into_iter().flatten().flatten();
        let children = tasks.filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
        let children = children.collect::<String>();
        // A child may end between listing and reading.
        let status = |id| fs::read_to_string(format!("/proc/{id}/status")).ok();
        let memory = |id| kib(&status(id)?, "VmHWM:").map(|kib| kib / 1024.0);
        children.split_whitespace().filter_map(memory).fold(0.0, f64::max)
    }

    /// Processor time per second over all looks.
    pub fn cores(&self) -> f64 {
        let (Some(first), Some(last)) = (self.samples.first(), self.samples.last()) else { return f64::NAN };
        (last.cpu_s - first.cpu_s) / (last.at_s - first.at_s)
    }

    /// The same by name of thread, the busiest first.
    pub fn cores_by_thread(&self) -> Vec<(String, f64)> {
        let (Some(first), Some(last)) = (self.samples.first(), self.samples.last()) else {
            return Vec::new();
        };
        let span_s = last.at_s - first.at_s;
        let share = |(name, seconds): (&String, &f64)| {
            (name.clone(), (seconds - first.threads_s.get(name).unwrap_or(&0.0)) / span_s)
        };
        let mut threads: Vec<_> = last.threads_s.iter().map(share).collect();
        threads.sort_by(|a, b| b.1.total_cmp(&a.1));
        threads
    }

    /// Mean memory in use between two times, MiB.
    pub fn resident_mib(&self, from_s: f64, to_s: f64) -> f64 {
        let inside: Vec<f64> = self
            .samples
            .iter()
            .filter(|sample| (from_s..=to_s).contains(&sample.at_s))
            .map(|sample| sample.resident_mib)
            .collect();
        inside.iter().sum::<f64>() / inside.len() as f64
    }
}

/// A line of `status`.
fn kib(status: &str, key: &str) -> Option<f64> {
    status.lines().find_map(|line| line.strip_prefix(key))?.split_whitespace().next()?.parse().ok()
}

/// Name and processor time of a `stat` line; the name is in parentheses and may hold anything.
fn times(stat: &str) -> Option<(String, f64)> {
    let (head, rest) = stat.rsplit_once(") ")?;
    let name = head.split_once('(')?.1.to_owned();
    let mut fields = rest.split_whitespace().skip(11); // utime and stime, fields 14 and 15 of the line
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((name, (user + system) / TICKS_PER_S))
}

#[cfg(test)]
mod tests {
    use super::times;

    #[test]
    fn the_times_of_a_process_are_found_behind_any_name() {
        let stat = "7 (a ) b) S 1 7 7 0 -1 4194560 100 0 0 0 250 50 0 0 20 0 4 0 100 1000 10";
        assert_eq!(times(stat), Some(("a ) b".into(), 3.0)));
    }
}
