//! Several missing effects at once: add the best, score again, try to swap each; at every step the open grammar is compared with
//! the catalogue (docs/design/statistics.md §3, §4).

use crate::diagnosis::model_comparison::{best_addition, ln_odds_required};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::view::{Item, View, What, columns_of};

/// Rounds of swapping.
const SWEEPS: usize = 2;
/// Additions tried for each that may stay.
const ROUNDS_PER_ITEM: usize = 2;

/// The set of additions that together explain what is left, at most `most`, and true when nothing worth claiming is left next to it.
pub fn search(scan: &Scan<'_>, first: &View, claim_ln: f64, most: usize) -> (Vec<Item>, bool) {
    let rows = scan.experiment.rows();
    let mut items: Vec<Item> = Vec::new();
    let mut next = best_addition(scan, first, &[], claim_ln);
    // Swapping may drop an item that comes back: the rounds are counted, not the items.
    for _ in 0..ROUNDS_PER_ITEM * most {
        let Some(item) = next else { return (items, true) };
        if items.len() == most {
            break;
        }
        items.push(item);
        if items.len() > 1 {
            swap(scan, &mut items, claim_ln);
        }
        let view = View::of(scan, columns_of(items.iter(), rows));
        next = best_addition(scan, &view, &taken(&items, usize::MAX), claim_ln);
    }
    (items, false)
}

fn swap(scan: &Scan<'_>, items: &mut Vec<Item>, claim_ln: f64) {
    let rows = scan.experiment.rows();
    for _ in 0..SWEEPS {
        let mut changed = false;
        let mut i = 0;
        while i < items.len() {
            let others = columns_of(items.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, x)| x), rows);
            let view = View::of(scan, others);
            match best_addition(scan, &view, &taken(items, i), claim_ln) {
                // The others explain it by now.
                None => {
                    items.remove(i);
                    changed = true;
                    continue;
                }
                Some(item) if item.what == items[i].what => items[i] = item,
                Some(item) => {
                    let stays = ln_odds_required(scan, &view, &items[i], &item);
                    if item.ln_odds > stays {
                        items[i] = item;
                        changed = true;
                    }
                }
            }
            i += 1;
        }
        if !changed {
            break;
        }
    }
}

fn taken(items: &[Item], except: usize) -> Vec<usize> {
    let named = |(j, item): (usize, &Item)| match item.what {
        What::Named(group) if j != except => Some(group),
        _ => None,
    };
    items.iter().enumerate().filter_map(named).collect()
}
