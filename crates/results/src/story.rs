//! One run as a person asks: what is wrong, how large, how sure, what to do; then where, which effect and why. A page shows
//! these texts and figures and makes none of its own.

use crate::diagnosis::Verdict;
use crate::identification::Parameter;
use crate::ladder::Ladder;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-story/1`: the answer about one run in the order of a page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Story {
    /// Format and version.
    pub format: StoryFormat,
    /// Names of the runs that were fitted together.
    pub runs: Vec<String>,
    /// Name of the machine.
    pub machine: String,
    /// Ids of the effects of the model, in order.
    pub model: Vec<String>,
    /// The verdict.
    pub verdict: Option<Verdict>,
    /// The answer in one line.
    pub headline: String,
    /// What is wrong and how large, one sentence each.
    pub wrong: Vec<String>,
    /// The figures of the fit.
    pub facts: Vec<Fact>,
    /// How sure that is.
    pub sure: Vec<String>,
    /// What to do.
    pub to_do: Vec<String>,
    /// Candidates, best first, with what is known of each; an expression that leads them is the first.
    pub candidates: Vec<StoryCandidate>,
    /// The effects that were added, with what each did.
    pub ladder: Ladder,
    /// Ids of the effects that can be taken out again.
    pub removable: Vec<String>,
    /// What these readings leave confounded.
    pub not_observable: Vec<String>,
    /// Effects that this cycle cannot show: the model imitates them.
    pub not_visible: Vec<String>,
    /// Effects that these runs cannot have.
    pub out_of_reach: Vec<String>,
    /// What is planned, read, missing and excluded.
    pub complete: Vec<String>,
    /// Why nothing can be added; empty for good runs.
    pub withheld: String,
    /// Charts and tables, in order.
    pub sections: Vec<StorySection>,
}

/// Format and version of a story.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum StoryFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-story/1")]
    V1,
}

/// A figure with its name, as a person reads it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// The figure with its unit; a dash where it is not known.
    pub value: String,
    /// Where it comes from.
    pub remark: String,
}

/// A candidate as a person reads it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StoryCandidate {
    /// Effect id, as `add` takes it.
    pub effect: String,
    /// Its name.
    pub title: String,
    /// Residual without and with it, each with its unit.
    pub falls: [String; 2],
    /// How significant it is.
    pub evidence: String,
    /// What speaks for it, and what it is: label and text.
    pub about: Vec<[String; 2]>,
    /// What the data do not distinguish from it.
    pub rivals: Vec<String>,
    /// The measurement that separates them; empty when it is confused with none.
    pub separate_by: String,
    /// How large it is: parameter, value and standard uncertainty.
    pub sizes: Vec<[String; 3]>,
    /// True for what leads, and for what was found together with it.
    pub found: bool,
}

/// A part of a report: charts and tables as markup without scripts and styles.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StorySection {
    /// Its name.
    pub id: String,
    /// Well-formed markup; texts in it are escaped.
    pub html: String,
}

/// `trunnion-runs/1`: the recordings of a folder, newest last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunList {
    /// Format and version.
    pub format: RunListFormat,
    /// One line for each.
    pub runs: Vec<RunLine>,
}

/// Format and version of a list of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum RunListFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-runs/1")]
    V1,
}

/// A recording in a list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunLine {
    /// Name of its file, as the other calls take it.
    pub name: String,
    /// Name of the machine.
    pub machine: String,
    /// When it began, s since 1970 UTC; null where the recording does not say.
    pub began_s: Option<i64>,
    /// The same for a person.
    pub began: String,
    /// Why it cannot be read; empty otherwise.
    pub trouble: String,
    /// When and why its samples were removed; its report stays. Empty while they are there.
    pub removed: String,
    /// What the last analysis found; null before the first.
    pub found: Option<RunFound>,
}

/// What an analysis found, in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunFound {
    /// The verdict.
    pub verdict: Verdict,
    /// The effect or formula that leads, if the verdict names one.
    pub candidate: Option<String>,
    /// All that the verdict names: the effects found together, best first, else the effect or formula that leads; empty in answers of
    /// older versions.
    #[serde(default)]
    pub named: Vec<String>,
    /// Residual of the fit, µm rms.
    pub rms_um: f64,
    /// Ids of the effects of the model.
    pub effects: Vec<String>,
    /// Location errors with their standard uncertainties.
    pub location_errors: Vec<Parameter>,
    /// Mean of all temperature channels, °C; null where none was recorded, and in answers of older versions.
    #[serde(default)]
    pub temperature_degc: Option<f64>,
}
