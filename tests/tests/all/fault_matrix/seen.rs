//! What is seen of a device, and whether it is what must follow.

use super::bench::NAME;
use super::matrix::{Case, GapOf};
use trunnion_acquire::DeviceState;
use trunnion_core::{Event, Gap};
use trunnion_tests::pattern::is_like;

/// Addresses, and what to call them.
pub type Names = [(String, &'static str); 2];

/// What was seen from the fault on; at the end, what the recording holds of it.
#[derive(Debug, Default)]
pub struct Seen {
    /// States, without those of attempts.
    pub states: Vec<DeviceState>,
    /// Lines of the log.
    pub reported: Vec<String>,
    pub gaps: Vec<Gap>,
}

impl Seen {
    pub fn gap_of(&mut self, gap: Gap, names: &Names) {
        self.gaps.push(Gap { reason: named(&gap.reason, names), ..gap });
    }

    pub fn line_of(&mut self, event: &Event, names: &Names) {
        if event.kind != "controller" {
            self.reported.push(named(&event.text, names));
        }
    }

    pub fn has_reported(&self, case: &Case) -> bool {
        case.message.is_empty() || self.reported.iter().any(|line| is_like(line, &case.message))
    }

    pub fn gap(&self, wanted: &GapOf) -> Option<&Gap> {
        let source = wanted.channel.map_or_else(|| NAME.to_owned(), |channel| format!("{NAME}.{channel}"));
        self.gaps.iter().find(|gap| {
            gap.source == source && is_like(&gap.reason, &wanted.reason) && wanted.lost.fits(gap.lost_samples)
        })
    }

    /// Time that lies in a gap of this source, s: a second session may leave a second gap.
    fn covered_s(&self, source: &str) -> f64 {
        let of_source = self.gaps.iter().filter(|gap| gap.source == source);
        let mut spans: Vec<(f64, f64)> = of_source.map(|gap| (gap.from_s, gap.to_s)).collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut covered_s, mut until_s) = (0.0, f64::NEG_INFINITY);
        for (from_s, to_s) in spans {
            covered_s += (to_s - from_s.max(until_s)).max(0.0);
            until_s = until_s.max(to_s);
        }
        covered_s
    }

    pub fn check(&self, case: &Case) -> Result<(), String> {
        let (states, course) = (&self.states, case.course);
        let fail = |what: String| Err(format!("{what}; seen: {self:#?}"));
        if states.first() != course.first()
            || states.last() != course.last()
            || states.iter().any(|state| !course.contains(state) && !case.may_be(*state))
            || course.iter().any(|state| !states.contains(state))
        {
            return fail(format!("the states are not {course:?}"));
        }
        if !self.has_reported(case) {
            return fail(format!("not reported: {}", case.message));
        }
        let Some(wanted) = &case.gap else {
            return match self.gaps.first() {
                None => Ok(()),
                Some(_) => fail("a gap although nothing is missing".into()),
            };
        };
        let Some(gap) = self.gap(wanted) else { return fail(format!("no gap \"{}\"", wanted.reason)) };
        if self.covered_s(&gap.source) < wanted.at_least_s {
            return fail(format!("gaps cover less than {} s", wanted.at_least_s));
        }
        Ok(())
    }
}

fn named(text: &str, names: &Names) -> String {
    names.iter().fold(text.to_owned(), |text, (address, name)| text.replace(address, name))
}
