//! The ladder: how the error fell with every effect that was added, and what each did to the location errors.

use super::trial::{clearly, moved_table};
use crate::added::by_whom;
use crate::markup::table;
use crate::number::{MISSING, um, um_or_dash};
use crate::svg::{Bar, bars};
use crate::words::{bars_legend, most_moved, moved_words, units_of};
use trunnion_results::{Ladder, LadderRow};

pub fn section(ladder: &Ladder) -> String {
    let Some((_, first)) = ladder.added().next() else { return String::new() };
    let start = Bar {
        name: "before anything was added".into(),
        fit_um: first.error_before_um,
        holdout_um: first.holdout_before_um,
        noise_um: first.noise_um,
        remark: String::new(),
    };
    let step = |(effect, row): (&str, &LadderRow)| Bar {
        name: format!("+ {effect}"),
        fit_um: row.error_after_um,
        holdout_um: row.holdout_after_um,
        noise_um: row.noise_um,
        remark: most_moved(&row.moved).map_or(String::new(), moved_words),
    };
    let steps: Vec<_> = std::iter::once(start).chain(ladder.added().map(step)).collect();
    let chart = bars(
        "Ladder: error after each effect",
        &format!(
            "{} Next to each effect: the location error that moved most when it came in, and by how many standard uncertainties u.",
            bars_legend(&units_of(ladder), ladder.added().find_map(|(_, row)| row.noise_um))
        ),
        &steps,
        None,
    );
    let rows: Vec<_> = ladder.added().map(row).collect();
    let head = [
        "effect added",
        "error before",
        "error after",
        "held-out before",
        "held-out after",
        "repeatability",
        "added by",
        "date",
        "run",
    ];
    let mut body = chart + &table("Error after each added effect, rms", &head, &[1, 2, 3, 4, 5], &rows);
    for (effect, row) in ladder.added() {
        let moved = clearly(&row.moved);
        if !moved.is_empty() {
            body += &moved_table(&format!("Moved by more than 2 u when {effect} came in"), &moved);
        }
    }
    format!("<section><h2>Ladder: what was added so far</h2>\n{body}</section>\n")
}

fn row((effect, row): (&str, &LadderRow)) -> Vec<String> {
    let [by, when] = by_whom(row);
    vec![
        effect.into(),
        um(row.error_before_um),
        um(row.error_after_um),
        um_or_dash(row.holdout_before_um),
        um_or_dash(row.holdout_after_um),
        um_or_dash(row.noise_um),
        by,
        when,
        if row.run.is_empty() { MISSING.into() } else { row.run.clone() },
    ]
}
