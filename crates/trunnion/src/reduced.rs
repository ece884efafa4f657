//! What became of the points of a long run on the way to its blocks: how many lay far from their neighbours, and where most of them.

use trunnion_core::convert::deg_from_rad;
use trunnion_cycles::Run;
use trunnion_results::{Doubt, Excluded};
use trunnion_sync::blocks::{PassSummary, Reduction};

/// Share of the points beyond which the probes are doubted. The rule that excludes them takes nine standard deviations, which noise never reaches,
/// so each is a fault of its own; a run of 2000 points has twenty of them then. A judgement, tuned on no data.
const MOST_LONE: f64 = 0.01;

/// How the points of a recording became fewer.
#[derive(Clone, Debug, Default)]
pub struct Reduced {
    /// In a sentence.
    pub summary: String,
    /// Readings at rest that points are means of.
    at_rest: Option<u64>,
    read: u64,
    lone: u64,
    passes: Vec<PassSummary>,
}

impl Reduced {
    /// Of a run on the fly.
    pub(crate) fn of_blocks(reduction: &Reduction) -> Self {
        Self {
            summary: reduction.summary(),
            at_rest: None,
            read: reduction.points_read,
            lone: reduction.points_excluded,
            passes: reduction.passes.clone(),
        }
    }

    /// Of a run at rest, of which no point is excluded: so many readings became means.
    pub(crate) fn of_stations(summary: String, readings: u64) -> Self {
        Self { summary, at_rest: Some(readings), ..Self::default() }
    }

    /// Readings at rest that the points are means of; `None` of a run on the fly.
    pub(crate) fn readings_at_rest(&self) -> Option<u64> {
        self.at_rest
    }

    /// Those of two files of one run together.
    pub(crate) fn and(mut self, mut next: Self) -> Self {
        self.passes.append(&mut next.passes);
        Self { read: self.read + next.read, lone: self.lone + next.lone, ..self }
    }

    /// Points excluded on the way.
    pub(crate) fn excluded(&self) -> Option<Excluded> {
        let count = usize::try_from(self.lone).unwrap_or(usize::MAX);
        (count > 0).then(|| Excluded { reason: "single readings far from their neighbours".into(), count })
    }

    /// A doubt about the readings of a run, where many were excluded.
    pub(crate) fn doubt(&self, run: &Run) -> Option<Doubt> {
        let is_many = self.lone as f64 > MOST_LONE * self.read as f64;
        is_many.then(|| Doubt::lone_readings(&run.name, [self.lone, self.read], self.most(run)))
    }

    /// Where most of them lie: `setup low, C forward at 5400°/min`.
    fn most(&self, run: &Run) -> Option<String> {
        let pass = self.passes.iter().max_by_key(|pass| pass.excluded).filter(|pass| pass.excluded > 0)?;
        let mut words = format!("setup {}", run.setups.get(pass.setup)?.name);
        for joint in run.machine.rotary_joints() {
            let direction = pass.direction[joint];
            if direction != 0.0 && pass.speed[joint] > 0.0 {
                let way = if direction > 0.0 { "forward" } else { "back" };
                let deg_per_min = 60.0 * deg_from_rad(pass.speed[joint]);
                words += &format!(", {joint} {way} at {deg_per_min:.0}°/min");
            }
        }
        Some(words)
    }
}
