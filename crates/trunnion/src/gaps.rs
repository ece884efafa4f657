//! What is missing from a recording: the gaps that its recorder wrote, live and afterwards by the same rule.

mod remounts;

use crate::{Error, page};
use std::path::Path;
use trunnion_core::{Gap, Point};
use trunnion_cycles::Cycle;
use trunnion_record::{Damage, Item};

pub use remounts::Remounts;

/// No program moves sooner after its start, s: what was missing before is no loss of the run.
const FIRST_MOTION_S: f64 = 0.05;

/// Gaps of a run, without those in which nothing was asked of the devices.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    all: Vec<Gap>,
    remounts: Remounts,
}

impl Gaps {
    /// A gap of the recording.
    pub fn take(&mut self, gap: Gap) {
        if gap.to_s > FIRST_MOTION_S {
            self.all.push(gap);
        }
    }

    /// A pose that was decided.
    pub fn pose(&mut self, point: &Point) {
        self.remounts.take(point);
    }

    /// All, before it is known which of them count.
    pub fn so_far(&self) -> &[Gap] {
        &self.all
    }

    /// Those in what was asked.
    pub fn finish(self) -> Vec<Gap> {
        self.all.into_iter().filter(|gap| !self.remounts.hold(gap)).collect()
    }
}

/// What is missing from a recording, in sentences with its file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Missing {
    /// Gaps in what was asked of the devices.
    pub gaps: Vec<String>,
    /// What is wrong with the file.
    pub damage: Option<String>,
}

impl Missing {
    /// What was found in the recording `path`.
    pub fn of(path: &Path, gaps: &[Gap], damage: Option<&Damage>) -> Self {
        let named = |text: String| format!("{}: {text}", path.display());
        Self {
            gaps: page::losses(gaps, 0).into_iter().map(named).collect(),
            damage: damage.map(|damage| named(damage.to_string())),
        }
    }

    /// The same of a recording that was read for its samples alone.
    pub(crate) fn of_samples(path: &Path, damage: Option<&Damage>) -> Result<Self, Error> {
        let (_, gaps) = gaps_of(path)?;
        Ok(Self::of(path, &gaps, damage))
    }
}

/// Name of the cycle of a recording, and the gaps in what was asked.
///
/// # Errors
/// A recording that cannot be read.
pub fn gaps_of(recording: &Path) -> Result<(String, Vec<Gap>), Error> {
    let mut gaps = Gaps::default();
    let mut take = |item: Item| {
        match item {
            Item::Gap(gap) => gaps.take(gap),
            Item::Point(point) => gaps.pose(&point),
            _ => {}
        }
        true
    };
    let (header, _) = trunnion_record::visit(recording, &mut take).map_err(Error::recording(recording))?;
    // A recording without a cycle is judged by the model of any.
    let cycle = Cycle::parse("recorded cycle", &header.cycle_text).map_or_else(|_| String::new(), |c| c.name);
    Ok((cycle, gaps.finish()))
}
