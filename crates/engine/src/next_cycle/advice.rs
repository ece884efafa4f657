//! A diagnosis that leaves rivals open gets the cycle that separates them.

use super::answer::Plan;
use super::choose::plan_problem;
use super::options::Options;
use super::planned::PlannedCycle;
use super::rivals::{Rivals, wanted};
use crate::Diagnosis;
use crate::problem::Problem;
use std::error::Error;
use std::f64::consts::LN_10;

/// Plans the next cycle when a candidate is confused with others, and leaves every other diagnosis as it is: planning takes
/// longer than the diagnosis itself. When no plan can be made the advice stays and says why.
pub fn advise(problem: &Problem<'_>, diagnosis: &mut Diagnosis, options: &Options) {
    if diagnosis.candidates.iter().all(|candidate| candidate.confused_with.is_empty()) {
        return;
    }
    let Rivals::Separate(rivals) = wanted(diagnosis) else { return };
    let next = diagnosis.next_cycle.get_or_insert_default();
    match plan_problem(problem, &Rivals::Separate(rivals), options) {
        Ok(plan) => {
            next.cycle = planned(&plan);
            next.suggestion = plan.answer;
        }
        Err(error) => next.suggestion += &format!(" No cycle could be planned: {}.", chain(&error)),
    }
}

fn planned(plan: &Plan) -> Option<PlannedCycle> {
    let (cycle, row) = plan.next.as_ref().zip(plan.considered.first())?;
    Some(PlannedCycle {
        name: cycle.name.clone(),
        what: row.what.clone(),
        minutes: row.minutes,
        separation_before: plan.before_ln / LN_10,
        separation: row.separation_ln / LN_10,
        separates: row.apart.clone(),
        file: cycle.to_text(),
    })
}

/// An error with its causes, for a sentence.
fn chain(error: &dyn Error) -> String {
    let cause = error.source().map_or(String::new(), |cause| format!(": {}", chain(cause)));
    format!("{error}{cause}")
}
