//! Which physical effect is missing from the model.
//!
//! The evidence of every catalogued effect is weighed against noise learned from the run itself (offsets of passes, re-positioning,
//! drift, a pattern that repeats), learned again with every candidate, and every candidate is compared with an open grammar of expressions
//! that have no name. The scan may look at a part of the points; what is printed of a candidate is the fit of the model with it to
//! all of them.

mod answer;
mod constancy;
mod entries;
mod expressions;
mod families;
pub mod judged;
mod judgement;
mod kept;
mod model_comparison;
mod named;
pub mod options;
mod refine;
mod refits;
mod rivals;
mod scan;
mod scored;
mod search;
mod signs;
mod sparse;
pub mod verdict;
mod view;
mod views;
mod vocabulary;
mod words;

pub use options::Options;

use crate::diagnosis::judged::Verdict;
use crate::problem::Problem;
use crate::problem::experiment::Experiment;
use answer::Answer;
use options::DiagnoseError;
use scan::Scan;
use trunnion_effects::Model;
use verdict::Diagnosis;
use views::Views;

/// Ranks the effects that the model lacks.
///
/// # Errors
/// A model that cannot be fitted, or too few readings.
pub fn diagnose(
    experiment: &Experiment,
    model: &Model,
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_problem(&Problem::new(experiment, model)?, options)
}

/// The same for a model that is fitted already.
///
/// # Errors
/// Too few readings.
pub fn diagnose_problem(problem: &Problem<'_>, options: &Options) -> Result<Diagnosis, DiagnoseError> {
    let mut options = options.clone();
    let (mut doubts, mut real): (Vec<String>, Option<Vec<String>>) = (Vec::new(), None);
    let mut resembling: Vec<String> = Vec::new();
    let scan_without =
        |without: &[String]| Ok::<_, DiagnoseError>((Scan::new(problem, without)?, Views::default()));
    let (mut scan, mut views) = scan_without(&options.without)?;
    loop {
        match answer::answer(problem, &scan, &views, &options)? {
            Answer::Diagnosis(diagnosis) => {
                return Ok(match real {
                    None if diagnosis.verdict == Verdict::MissingEffect || resembling.is_empty() => {
                        *diagnosis
                    }
                    None => diagnosis.doubted(problem.experiment(), &resembling, &[]),
                    Some(real) => diagnosis.doubted(problem.experiment(), &doubts, &real),
                });
            }
            Answer::Without { effect, why, with } => {
                let is_real = |id: &String| real.as_ref().is_none_or(|real| real.contains(id));
                real = Some(with.into_iter().filter(is_real).collect());
                options.without.push(effect);
                doubts.push(why);
                (scan, views) = scan_without(&options.without)?;
            }
            Answer::Resembles { effect, why } => {
                options.without.push(effect);
                resembling.push(why);
                (scan, views) = scan_without(&options.without)?;
            }
            Answer::NotAdded { effect } => options.not_added.push(effect),
        }
    }
}
