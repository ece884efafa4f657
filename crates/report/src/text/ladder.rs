//! The ladder as bars of characters: error of the fit, held-out error and repeatability of every rung.

use super::table::{columns, longest_bar, moved_table};
use crate::added::by_whom;
use crate::number::um_or_dash;
use crate::words::{most_moved, moved_words, units_of};
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
    let head = ["added", "fit", "held-out", "noise"].map(String::from).to_vec();
    let floor = |row: &LadderRow| row.noise_um.or(noise_um);
    let start = ("(before)".into(), [Some(first.error_before_um), first.holdout_before_um, floor(first)]);
    let steps = ladder.added().map(|(effect, row)| {
        (format!("+ {effect}"), [Some(row.error_after_um), row.holdout_after_um, floor(row)])
    });
    let steps: Vec<(String, [Option<f64>; 3])> = once(start).chain(steps).collect();
    let cells = |(name, values): &(String, [Option<f64>; 3])| {
        once(name.clone()).chain(values.map(um_or_dash)).collect::<Vec<_>>()
    };
    let mut rows: Vec<Vec<String>> = once(head).chain(steps.iter().map(cells)).collect();
    let longest = longest_bar(&rows);
    for (row, (_, values)) in rows.iter_mut().skip(1).zip(&steps) {
        row.push(marked_bar(*values, largest, longest));
    }
    let mut out = columns(&rows, &[1, 2, 3]);
    let held_out = match units_of(ladder)[..] {
        [] => String::new(),
        ref units => format!(" o error on {} left out of the fit,", units.join(" or ")),
    };
    out += &format!("Bars: # error of the fit,{held_out} | repeatability; µm rms.\n");
    for (effect, row) in ladder.added().filter(|(_, row)| row.by.is_some()) {
        out += &format!("{effect}: added by {}.\n", by_whom(row).join(", "));
    }
    for (effect, row) in ladder.added() {
        let moved: Vec<_> = row.moved.iter().filter(|m| m.in_u() > 2.0).cloned().collect();
        if !moved.is_empty() {
            out += &format!("\nMoved by more than 2 u when {effect} came in\n{}", moved_table(&moved));
        } else if let Some(most) = most_moved(&row.moved) {
            out += &format!(
                "\nNothing moved by more than 2 u when {effect} came in. The location error that moved most: {}.\n",
                moved_words(most)
            );
        }
    }
    out
}

/// `######|###   o`.
fn marked_bar([fit_um, holdout_um, noise_um]: [Option<f64>; 3], largest_um: f64, longest: f64) -> String {
    // The last character is for the mark of the largest value.
    let place = |value: f64| {
        let share = value / largest_um;
        share.is_finite().then(|| (share * (longest - 1.0)).round().clamp(0.0, longest - 1.0) as usize)
    };
    let mut bar = vec![' '; longest as usize];
    bar[..fit_um.and_then(place).unwrap_or(0)].fill('#');
    for (value, mark) in [(noise_um, '|'), (holdout_um, 'o')] {
        if let Some(at) = value.and_then(place) {
            bar[at] = mark;
        }
    }
    bar.into_iter().collect::<String>().trim_end().to_string()
}
