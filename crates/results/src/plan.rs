//! What to measure next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::LN_10;
use trunnion_engine::next_cycle;

pub use trunnion_engine::next_cycle::Goal;

/// `trunnion-plan/1`: the next cycle. Separations are log₁₀ of expected Bayes factors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Plan {
    /// Format and version.
    pub format: PlanFormat,
    /// What the cycle is for.
    pub goal: Goal,
    /// The effects in question.
    pub effects: Vec<String>,
    /// Those that no cycle considered would show.
    pub never_shown: Vec<String>,
    /// Separation of the hardest pair in the present data.
    pub separation_before: f64,
    /// The cycle to measure next; null when no cycle of poses and feeds helps.
    pub next: Option<NextPlanned>,
    /// Pairs that are still confused after the next cycle.
    pub left_open: Vec<LeftOpen>,
    /// The answer in words.
    pub answer: String,
    /// Cycles considered, best first.
    pub considered: Vec<Considered>,
    /// What was assumed of machine time and noise.
    pub assumptions: Vec<String>,
    /// The file that was written.
    #[serde(default)]
    pub written: Option<String>,
}

/// Format and version of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PlanFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-plan/1")]
    V1,
}

/// The chosen cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextPlanned {
    /// Its name.
    pub name: String,
    /// Machine time with mounting, min.
    pub minutes: Option<f64>,
    /// Separation of the hardest pair afterwards.
    pub separation_after: Option<f64>,
    /// The cycle file, `trunnion-cycle/1`.
    pub cycle: String,
}

/// Two effects that the next cycle does not separate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOpen {
    /// The two.
    pub pair: [String; 2],
    /// The cheapest cycle considered that would; null when none does.
    pub separated_by: Option<String>,
}

/// One cycle that was considered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Considered {
    /// Its name.
    pub name: String,
    /// What it does.
    pub what: String,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// Separation of the hardest pair afterwards.
    pub separation: f64,
    /// The hardest pair.
    pub hardest_pair: [String; 2],
    /// Pairs that it separates.
    pub pairs_apart: usize,
    /// Effects that it shows.
    pub shows: Vec<String>,
    /// Effects that it separates from all others in question.
    #[serde(alias = "tells_apart")]
    pub separates: Vec<String>,
}

impl From<&next_cycle::Plan> for Plan {
    fn from(plan: &next_cycle::Plan) -> Self {
        Self {
            format: PlanFormat::V1,
            goal: plan.goal,
            effects: plan.effects.clone(),
            never_shown: plan.never_shown.clone(),
            separation_before: plan.before_ln / LN_10,
            next: plan.planned.as_ref().map(|cycle| NextPlanned {
                name: cycle.name.clone(),
                minutes: Some(cycle.minutes),
                separation_after: cycle.separation,
                cycle: cycle.file.clone(),
            }),
            left_open: plan
                .left_open
                .iter()
                .map(|open| LeftOpen { pair: open.pair.clone(), separated_by: open.by.clone() })
                .collect(),
            answer: plan.answer.clone(),
            considered: plan.considered.iter().map(considered).collect(),
            assumptions: plan.assumptions.clone(),
            written: None,
        }
    }
}

fn considered(row: &next_cycle::Considered) -> Considered {
    Considered {
        name: row.name.clone(),
        what: row.what.clone(),
        minutes: row.minutes,
        separation: row.separation_ln / LN_10,
        hardest_pair: row.hardest.clone(),
        pairs_apart: row.apart.len(),
        shows: row.shows.clone(),
        separates: row.separates.clone(),
    }
}
