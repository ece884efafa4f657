//! What to measure next after a diagnosis: the cycle that separates the rivals that it leaves open; where it decides nothing, the present
//! one once more. `diagnose`, every report and `plan` have it from here.

use super::again::again;
use super::answer::{Plan, assumptions};
use super::choose::plan_problem;
use super::options::{Options, PlanError};
use super::planned::{Goal, PlannedCycle};
use super::rivals::{Rivals, wanted};
use crate::diagnosis::judged::Verdict;
use crate::problem::Problem;
use crate::{Diagnosis, NextCycle};
use trunnion_core::chain;
use trunnion_cycles::Cycle;

/// Plans the next cycle of a diagnosis that leaves rivals open or decides nothing. Every other diagnosis stays as it is: what the present cycle does
/// not show is planned for when somebody asks, as planning takes longer than the diagnosis itself. When no plan can be made the advice stays
/// and says why.
pub fn advise(problem: &Problem<'_>, diagnosis: &mut Diagnosis, options: &Options) {
    let open = wanted(diagnosis);
    let said = match &open {
        Rivals::Separate(_) => separated(problem, diagnosis, &open, options).map(Separated::advice),
        Rivals::Reveal(_) => Ok(repeated(problem, diagnosis, options).advice()),
    };
    match said {
        Ok(said) => diagnosis.next_cycle = said,
        Err(error) => {
            let mut advice = repeated(problem, diagnosis, options).advice().unwrap_or_default();
            advice.suggestion += &format!(" No cycle could be planned: {}.", chain(&error));
            diagnosis.next_cycle = Some(advice);
        }
    }
}

/// The same as a plan, and for a diagnosis that leaves nothing open a cycle that shows what the present one does not. `None` where there is
/// nothing to measure.
///
/// # Errors
/// As [`super::plan`].
pub fn next(
    problem: &Problem<'_>,
    diagnosis: &Diagnosis,
    options: &Options,
) -> Result<Option<Plan>, PlanError> {
    let open = wanted(diagnosis);
    let hidden = match &open {
        Rivals::Separate(_) => {
            return Ok(Some(separated(problem, diagnosis, &open, options)?.plan()));
        }
        Rivals::Reveal(hidden) => hidden,
    };
    let repeated = repeated(problem, diagnosis, options);
    let plan = if hidden.is_empty() { None } else { Some(plan_problem(problem, &open, options)?) };
    Ok(match (repeated.suggestion.is_empty(), plan) {
        (true, plan) => plan,
        (false, plan) => Some(repeated.first(plan.unwrap_or_else(|| nothing_hidden(options)))),
    })
}

/// A plan that separates rivals, and what an undecided diagnosis says where there is none.
struct Separated {
    plan: Plan,
    instead: Option<Repeated>,
}

/// What a diagnosis says where it has no rivals: what to do, and the present poses as a cycle.
struct Repeated {
    suggestion: String,
    again: Option<(Cycle, PlannedCycle)>,
}

/// Where nothing was found, repeats decide what no cycle separates.
fn separated(
    problem: &Problem<'_>,
    diagnosis: &Diagnosis,
    rivals: &Rivals,
    options: &Options,
) -> Result<Separated, PlanError> {
    let plan = plan_problem(problem, rivals, options)?;
    let none = diagnosis.verdict == Verdict::Undecided && plan.next.is_none();
    Ok(Separated { instead: none.then(|| repeated(problem, diagnosis, options)), plan })
}

fn repeated(problem: &Problem<'_>, diagnosis: &Diagnosis, options: &Options) -> Repeated {
    let suggestion = diagnosis.next_cycle.as_ref().map(|next| next.suggestion.clone());
    match diagnosis.verdict {
        Verdict::Undecided => Repeated {
            suggestion: suggestion.unwrap_or_else(|| NextCycle::repeat(problem.experiment()).suggestion),
            again: again(problem.experiment(), options),
        },
        _ => Repeated { suggestion: suggestion.unwrap_or_default(), again: None },
    }
}

impl Separated {
    fn advice(self) -> Option<NextCycle> {
        match self.instead {
            Some(repeated) => repeated.advice(),
            None => Some(NextCycle { suggestion: self.plan.answer, cycle: self.plan.planned }),
        }
    }

    fn plan(self) -> Plan {
        match self.instead {
            Some(repeated) => repeated.first(self.plan),
            None => self.plan,
        }
    }
}

impl Repeated {
    fn advice(self) -> Option<NextCycle> {
        let cycle = self.again.map(|(_, planned)| planned);
        (!self.suggestion.is_empty()).then_some(NextCycle { suggestion: self.suggestion, cycle })
    }

    /// In front of what else could be measured.
    fn first(self, mut plan: Plan) -> Plan {
        plan.answer = format!("{} {}", self.suggestion, plan.answer).trim_end().into();
        match self.again {
            Some((cycle, planned)) => {
                (plan.goal, plan.next, plan.planned) = (Goal::Repeat, Some(cycle), Some(planned));
            }
            None if plan.next.is_none() => plan.goal = Goal::Repeat,
            None => {}
        }
        plan
    }
}

/// The plan where the present cycle shows everything.
fn nothing_hidden(options: &Options) -> Plan {
    Plan {
        goal: Goal::Repeat,
        effects: Vec::new(),
        never_shown: Vec::new(),
        before_ln: 0.0,
        considered: Vec::new(),
        next: None,
        planned: None,
        left_open: Vec::new(),
        answer: String::new(),
        assumptions: assumptions(&options.pace),
    }
}
