//! Which part of the run was read.

/// Times of the messages read so far, ns since 1970.
#[derive(Default)]
pub struct Times {
    first: Option<u64>,
    last: u64,
}

impl Times {
    /// A message was read.
    pub fn take(&mut self, time: u64) {
        self.first.get_or_insert(time);
        self.last = time.max(self.last);
    }

    /// Since the first message, s.
    pub fn of_run_s(&self, time: u64) -> f64 {
        time.saturating_sub(self.first.unwrap_or(time)) as f64 * 1e-9
    }

    /// What is missing of the run where reading ends.
    pub fn lost_after(&self, end: u64) -> String {
        let lost = format!("everything after {:.1} s of the run", self.of_run_s(self.last));
        if end > self.last {
            format!("{lost}, which went on to {:.1} s or longer", self.of_run_s(end))
        } else {
            lost
        }
    }
}
