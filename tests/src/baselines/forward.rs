//! Forward selection by BIC: the effect, at one of its shapes, that lowers BIC most; then the best next to it, and so on until none
//! lowers it. Pointing programs of telescopes choose their terms in this way.

use super::problem::{Baseline, Problem};

pub const BASELINE: Baseline = Baseline { name: "forward selection by BIC", chosen };

fn chosen(problem: &Problem) -> Vec<usize> {
    let blocks = problem.block_of.last().map_or(0, |last| last + 1);
    let columns_of = |block: usize| {
        let from = problem.block_of.partition_point(|&b| b < block);
        from..problem.block_of.partition_point(|&b| b <= block)
    };
    let mut chosen = Vec::new();
    let mut reached = problem.bic(&chosen);
    loop {
        let with = |block: usize| chosen.iter().copied().chain(columns_of(block)).collect::<Vec<usize>>();
        let free = (0..blocks).filter(|&block| !columns_of(block).any(|j| chosen.contains(&j)));
        let scored = free.map(|block| (problem.bic(&with(block)), block));
        let Some((bic, block)) = scored.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if bic >= reached {
            break;
        }
        (reached, chosen) = (bic, with(block));
    }
    chosen
}
