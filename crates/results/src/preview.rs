//! What a cycle does not show, before anything is measured.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_engine::next_cycle;

/// `trunnion-preview/1`: what a cycle shows, and which effects coincide in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Preview {
    /// Format and version.
    pub format: PreviewFormat,
    /// Name of the cycle.
    pub cycle: String,
    /// Points that it reads.
    pub points: usize,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// Effects that it shows.
    pub visible: Vec<String>,
    /// Effects that the base model imitates in it.
    pub invisible: Vec<SeenBy>,
    /// Effects that it cannot have at all.
    pub out_of_reach: Vec<OutOfReach>,
    /// Effects that coincide in it.
    pub aliases: Vec<Alias>,
}

/// Format and version of a preview.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PreviewFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-preview/1")]
    V1,
}

/// An effect, and what shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SeenBy {
    /// Effect id.
    pub effect: String,
    /// What would show it.
    pub seen_by: String,
}

/// An effect, and what it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutOfReach {
    /// Effect id.
    pub effect: String,
    /// What it needs.
    pub why: String,
}

/// Two effects that coincide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Alias {
    /// The one, with its shape where it has one.
    pub one: String,
    /// The other.
    pub other: String,
    /// Directions of the smaller one that the other imitates exactly.
    pub shared_directions: usize,
    /// Directions that each can show.
    pub directions: [usize; 2],
    /// The cheapest cycle considered that separates them; null when none does.
    pub separated_by: Option<SeparatedBy>,
    /// What is known to separate them, from the catalogue.
    pub advice: String,
}

/// A cycle that separates two effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SeparatedBy {
    /// Its name.
    pub name: String,
    /// Machine time with mounting, min.
    pub minutes: f64,
}

impl From<&next_cycle::Preview> for Preview {
    fn from(preview: &next_cycle::Preview) -> Self {
        let seen_by = |(effect, seen_by): &(String, String)| SeenBy {
            effect: effect.clone(),
            seen_by: seen_by.clone(),
        };
        let needs =
            |(effect, why): &(String, String)| OutOfReach { effect: effect.clone(), why: why.clone() };
        Self {
            format: PreviewFormat::V1,
            cycle: preview.cycle.clone(),
            points: preview.points,
            minutes: preview.minutes,
            visible: preview.visible.clone(),
            invisible: preview.invisible.iter().map(seen_by).collect(),
            out_of_reach: preview.out_of_reach.iter().map(needs).collect(),
            aliases: preview.aliases.iter().map(Alias::from).collect(),
        }
    }
}

impl From<&next_cycle::Alias> for Alias {
    fn from(alias: &next_cycle::Alias) -> Self {
        Self {
            one: alias.one.clone(),
            other: alias.other.clone(),
            shared_directions: alias.shared,
            directions: alias.directions,
            separated_by: alias
                .separated_by
                .as_ref()
                .map(|(name, minutes)| SeparatedBy { name: name.clone(), minutes: *minutes }),
            advice: alias.advice.clone(),
        }
    }
}
