//! Which effects to separate: those a diagnosis confuses, or those the present cycle cannot see.

use crate::diagnosis::judged::Verdict;
use crate::{Diagnosis, FormulaProposal};
use trunnion_effects::{Formula, Instance, ModelEffect, UnknownEffect};
use trunnion_machine::Machine;

/// What a plan is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Rivals {
    /// Effects that explain the present data alike; one of them is the truth.
    Separate(Vec<ModelEffect>),
    /// Effects the present cycle cannot see; any of them may be there.
    Reveal(Vec<ModelEffect>),
}

impl Rivals {
    /// The effects.
    pub fn entries(&self) -> &[ModelEffect] {
        match self {
            Self::Separate(entries) | Self::Reveal(entries) => entries,
        }
    }

    /// Their ids.
    pub fn ids(&self) -> Vec<String> {
        self.entries().iter().map(|entry| entry.id.clone()).collect()
    }
}

/// Effects compared with each other, at most: as many as a diagnosis lists as candidates.
const MOST_UNDECIDED: usize = 6;

/// What a diagnosis leaves open: the effects it is undecided between; its first candidate that is confused with others; a formula
/// that leads against the named effect it resembles; otherwise everything the present cycle cannot see.
pub fn wanted(diagnosis: &Diagnosis) -> Rivals {
    if diagnosis.verdict == Verdict::Undecided && diagnosis.undecided.len() > 1 {
        let open = diagnosis.undecided.iter().take(MOST_UNDECIDED);
        return Rivals::Separate(open.map(|open| named(&open.effect)).collect());
    }
    if let Some(best) = diagnosis.candidates.iter().find(|candidate| !candidate.confused_with.is_empty()) {
        let ids = std::iter::once(&best.effect).chain(&best.confused_with);
        return Rivals::Separate(ids.map(|id| named(id)).collect());
    }
    // Next to a name that explains most it is another part, and no rival.
    if diagnosis.verdict == Verdict::UnnamedStructure
        && let Some(formula) = &diagnosis.formula
        && let Some(resembles) = &formula.resembles
    {
        return Rivals::Separate(vec![formula_entry(formula), named(resembles)]);
    }
    let hidden = diagnosis.not_visible.iter().chain(&diagnosis.out_of_reach);
    Rivals::Reveal(hidden.map(|id| named(id)).collect())
}

/// Effects named by a user.
///
/// # Errors
/// An id that this machine cannot have.
pub fn rivals_named(ids: &[String], machine: &Machine) -> Result<Rivals, UnknownEffect> {
    for id in ids {
        Instance::find(id, machine)?;
    }
    Ok(Rivals::Separate(ids.iter().map(|id| named(id)).collect()))
}

fn named(id: &str) -> ModelEffect {
    ModelEffect { id: id.into(), ..ModelEffect::default() }
}

/// Its first component, with the values of its shape numbers.
fn formula_entry(formula: &FormulaProposal) -> ModelEffect {
    formula.entries.first().cloned().unwrap_or_else(|| named(&Formula::id_of(&formula.name)))
}
