//! The ladder as bars of characters: error of the fit, held-out error and repeatability of every rung.

use super::table::{BAR, columns, moved_table};
use crate::number::{um, um_or_dash};
use crate::words::{most_moved, moved_words};
use std::iter::once;
use trunnion_results::{Ladder, LadderRow};

/// The ladder as a table with bars; `noise_um` is the repeatability where known.
pub fn ladder_text(ladder: &Ladder, noise_um: Option<f64>) -> String {
    let Some((_, first)) = ladder.added().next() else {
        return "No effect was added to this model yet.\n".into();
    };
    let fits = ladder.added().flat_map(|(_, row)| [Some(row.error_after_um), row.holdout_after_um]);
    let fits = fits.chain([Some(first.error_before_um), first.holdout_before_um, noise_um]).flatten();
    let largest = fits.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let head = ["added", "fit", "held-out", "noise", "", "location error that moved most"];
    let step = |name: String, fit_um: f64, holdout_um: Option<f64>, noise_um: Option<f64>, moved: String| {
        let bar = marked_bar(fit_um, holdout_um, noise_um, largest);
        vec![name, um(fit_um), um_or_dash(holdout_um), um_or_dash(noise_um), bar, moved]
    };
    let floor = |row: &LadderRow| row.noise_um.or(noise_um);
    let start =
        step("(before)".into(), first.error_before_um, first.holdout_before_um, floor(first), String::new());
    let steps = ladder.added().map(|(effect, row)| {
        let moved = most_moved(&row.moved).map_or(String::new(), moved_words);
        step(format!("+ {effect}"), row.error_after_um, row.holdout_after_um, floor(row), moved)
    });
    let table: Vec<_> = once(head.map(String::from).to_vec()).chain(once(start)).chain(steps).collect();
    let mut out = columns(&table, &[1, 2, 3]);
    out += "Bars: # error of the fit, o error on data left out of the fit, | repeatability; µm rms.\n";
    for (effect, row) in ladder.added().filter(|(_, row)| row.moved.iter().any(|m| m.in_u() > 2.0)) {
        out += &format!("\nMoved by more than 2 u when {effect} came in\n");
        let moved: Vec<_> = row.moved.iter().filter(|m| m.in_u() > 2.0).cloned().collect();
        out += &moved_table(&moved);
    }
    out
}

/// `######|###   o`.
fn marked_bar(fit_um: f64, holdout_um: Option<f64>, noise_um: Option<f64>, largest: f64) -> String {
    let place = |value: f64| {
        let share = value / largest;
        share.is_finite().then(|| (share * BAR).round().clamp(0.0, BAR) as usize)
    };
    let mut bar = vec![' '; BAR as usize + 1];
    bar[..place(fit_um).unwrap_or(0)].fill('#');
    for (value, mark) in [(noise_um, '|'), (holdout_um, 'o')] {
        if let Some(at) = value.and_then(place) {
            bar[at] = mark;
        }
    }
    bar.into_iter().collect::<String>().trim_end().to_string()
}
