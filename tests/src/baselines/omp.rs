//! Orthogonal matching pursuit [Pati 1993]: the column that correlates most with what is left, then least squares with all chosen so
//! far; ends where BIC no longer falls.

use super::problem::{Baseline, Problem};

pub const BASELINE: Baseline = Baseline { name: "OMP, number by BIC", chosen };

fn chosen(problem: &Problem) -> Vec<usize> {
    let mut chosen = Vec::new();
    let mut reached = problem.bic(&chosen);
    loop {
        let x = problem.solve(&chosen, 0.0);
        let left = &problem.score - problem.gram.select_columns(&chosen) * x;
        let free = (0..left.len()).filter(|j| !chosen.contains(j));
        let Some(best) = free.max_by(|&a, &b| left[a].abs().total_cmp(&left[b].abs())) else { break };
        chosen.push(best);
        let bic = problem.bic(&chosen);
        if bic >= reached {
            chosen.pop();
            break;
        }
        reached = bic;
    }
    chosen
}
