//! Samples of a cycle on the fly by what became of them.

use super::pace::Motion;

/// Samples taken inside the span of a cycle while the machine moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleCounts {
    /// Those that became points.
    pub used: u64,
    /// Those at another speed than a feed of the cycle, speeding up and slowing down with them.
    pub other_speed: u64,
    /// Those that lack a channel.
    pub incomplete: u64,
    /// Those of no pass that was still to come.
    pub unplanned: u64,
    /// Sum of the squares of what the stamps of the axes are off by, s².
    late_s2: f64,
}

impl SampleCounts {
    pub(super) fn take(&mut self, motion: &Motion) {
        self.used += 1;
        self.late_s2 += (motion.scatter_rad / motion.pace.0).powi(2);
    }

    /// Those of two files of one run together.
    #[must_use]
    pub fn and(&self, next: &Self) -> Self {
        Self {
            used: self.used + next.used,
            other_speed: self.other_speed + next.other_speed,
            incomplete: self.incomplete + next.incomplete,
            unplanned: self.unplanned + next.unplanned,
            late_s2: self.late_s2 + next.late_s2,
        }
    }

    /// All of them.
    pub fn all(&self) -> u64 {
        self.used + self.excluded().iter().map(|(count, _)| count).sum::<u64>()
    }

    /// Those that became no point, with the reason.
    pub fn excluded(&self) -> [(u64, &'static str); 3] {
        [
            (self.other_speed, "speeding up, slowing down or at no feed of the cycle"),
            (self.incomplete, "a channel had no value"),
            (self.unplanned, "no pass of the cycle was left for them"),
        ]
    }

    /// Share of the samples that became points; `None` without samples.
    pub fn share_used(&self) -> Option<f64> {
        (self.all() > 0).then(|| self.used as f64 / self.all() as f64)
    }

    /// Jitter of the axis stamps (rms): the scatter of the positions about a smooth motion over the speed, s; `None` without samples.
    pub fn jitter_s(&self) -> Option<f64> {
        (self.used > 0).then(|| (self.late_s2 / self.used as f64).sqrt())
    }

    /// One line for a person; `None` without samples.
    pub fn summary(&self) -> Option<String> {
        let share = |count: u64| 100.0 * count as f64 / self.all() as f64;
        let excluded = self.excluded().into_iter().filter(|(count, _)| *count > 0);
        let reasons: Vec<String> = excluded
            .map(|(count, reason)| format!("{count} excluded ({:.1} %): {reason}", share(count)))
            .collect();
        let mut text = format!(
            "{} of {} samples used ({:.1} %); axis stamps jitter by {:.2} ms",
            self.used,
            self.all(),
            share(self.used),
            1e3 * self.jitter_s()?
        );
        for reason in reasons {
            text += &format!("; {reason}");
        }
        Some(text)
    }
}
