//! A diagnosis that leaves rivals open gets the cycle that separates them; one that decides nothing, the cycle that may.

use super::again::again;
use super::answer::Plan;
use super::choose::plan_problem;
use super::options::Options;
use super::planned::PlannedCycle;
use super::rivals::{Rivals, wanted};
use crate::diagnosis::judged::Verdict;
use crate::problem::Problem;
use crate::{Diagnosis, NextCycle};
use std::f64::consts::LN_10;
use trunnion_core::chain;

/// Plans the next cycle when a candidate is confused with others, or the data are undecided between effects; where no cycle separates
/// these, an undecided answer has the present cycle once more. Every other diagnosis stays as it is: planning takes longer than the
/// diagnosis itself. When no plan can be made the advice stays and says why.
pub fn advise(problem: &Problem<'_>, diagnosis: &mut Diagnosis, options: &Options) {
    let undecided = diagnosis.verdict == Verdict::Undecided;
    let confused = diagnosis.candidates.iter().any(|candidate| !candidate.confused_with.is_empty());
    if !undecided && !confused {
        return;
    }
    let rivals = wanted(diagnosis);
    let next = diagnosis.next_cycle.get_or_insert_with(|| match undecided {
        true => NextCycle::repeat(),
        false => NextCycle::default(),
    });
    separate(problem, rivals, next, undecided, options);
    if undecided {
        next.cycle = next.cycle.take().or_else(|| again(problem.experiment(), options));
    }
}

fn separate(problem: &Problem<'_>, rivals: Rivals, next: &mut NextCycle, undecided: bool, options: &Options) {
    if let Rivals::Reveal(_) = rivals {
        return;
    }
    match plan_problem(problem, &rivals, options) {
        // Where nothing was found, repeats decide what no cycle separates.
        Ok(plan) if undecided && plan.next.is_none() => {}
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
        separation_before: Some(plan.before_ln / LN_10),
        separation: Some(row.separation_ln / LN_10),
        separates: row.apart.clone(),
        file: cycle.to_text(),
    })
}
