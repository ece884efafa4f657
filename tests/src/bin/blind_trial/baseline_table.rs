//! The table that sets plain methods of choosing columns beside the diagnosis.

use crate::cases::Group;
use crate::noise::Kind as NoiseKind;
use crate::table::{counted, markdown};
use crate::trial::Trial;
use std::collections::BTreeSet;
use trunnion_tests::baselines::BASELINES;

/// Sizes at which effects count, σ.
const SIZES: [f64; 2] = [1.0, 2.0];

/// The section, empty when no trial asked these methods.
pub fn section(trials: &[Trial]) -> String {
    let asked: Vec<&Trial> = trials.iter().filter(|trial| !trial.baselines.is_empty()).collect();
    if asked.is_empty() {
        return String::new();
    }
    let heading = [
        "method",
        "noise",
        "nothing hidden: names something",
        "false names each",
        "one hidden: among its names",
        "exactly it",
        "false names each",
        "two hidden: both among its names",
        "exactly both",
        "false names each",
    ];
    let mut rows = Vec::new();
    for noise in NoiseKind::ALL {
        let of_noise: Vec<&Trial> = asked.iter().copied().filter(|trial| trial.case.noise == noise).collect();
        if of_noise.is_empty() {
            continue;
        }
        for (k, baseline) in BASELINES.iter().enumerate() {
            rows.push(row(baseline.name, noise, &of_noise, &|trial| trial.baselines[k].clone()));
        }
        rows.push(row("trunnion", noise, &of_noise, &|trial| trial.found.iter().cloned().collect()));
    }
    format!(
        "\n## The same trials given to methods that choose columns\n\n\
        STLSQ (sequentially thresholded least squares, as in sparse identification of dynamics), orthogonal matching pursuit and forward \
        selection of whole effects (as pointing programs of telescopes do) get the columns of every effect of the catalogue at every \
        shape of its grid, and the readings without outliers, the base model projected out of both. They are in `tests/src/baselines`; \
        each counts with BIC. Effects of 1 σ and 2 σ. An effect counts as named when one of its columns is; a name is false when it is not \
        hidden, also where it says the same on these poses.\n\n{}",
        markdown(&heading.map(String::from), &rows)
    )
}

fn row(
    method: &str,
    noise: NoiseKind,
    trials: &[&Trial],
    names: &dyn Fn(&Trial) -> BTreeSet<String>,
) -> Vec<String> {
    let mut row = vec![method.to_string(), noise.name().into()];
    for group in [Group::Null, Group::Single, Group::Pair] {
        let of_group: Vec<&&Trial> = trials
            .iter()
            .filter(|trial| trial.case.group == group)
            .filter(|trial| group == Group::Null || SIZES.contains(&trial.case.size))
            .collect();
        let answers: Vec<(BTreeSet<String>, BTreeSet<String>)> =
            of_group.iter().map(|trial| (trial.wanted.iter().cloned().collect(), names(trial))).collect();
        let of = answers.len();
        let count = |right: fn(&BTreeSet<String>, &BTreeSet<String>) -> bool| {
            counted(answers.iter().filter(|(wanted, named)| right(wanted, named)).count(), of)
        };
        let false_names: usize = answers.iter().map(|(wanted, named)| named.difference(wanted).count()).sum();
        if of == 0 {
            row.extend(std::iter::repeat_n("–".into(), if group == Group::Null { 2 } else { 3 }));
            continue;
        }
        if group == Group::Null {
            row.push(count(|_, named| !named.is_empty()));
        } else {
            row.extend([
                count(|wanted, named| wanted.is_subset(named)),
                count(|wanted, named| wanted == named),
            ]);
        }
        row.push(format!("{:.1}", false_names as f64 / of as f64));
    }
    row
}
