//! The ladder: how the error fell with every effect that was added.

use crate::markup::table;
use crate::number::{MISSING, um, um_or_dash, with_unit};
use crate::svg::{Bar, bars};
use crate::{CompareInput, LadderRow};

pub fn section(input: &CompareInput) -> String {
    let noise_um = input.identification.noise.rms_um;
    let steps = steps(input);
    let chart = bars(
        "Ladder: error after each effect",
        "Bars: error of the fit. Diamonds: error on data left out of the fit. Dashed: noise floor.",
        &steps,
        noise_um,
    );
    let rows: Vec<_> = input.ladder.iter().map(row).collect();
    let head = [
        "effect added",
        "error before",
        "error after",
        "held-out before",
        "held-out after",
        "location error moved most",
        "date",
        "run",
    ];
    let rows = if rows.is_empty() {
        "<p class=\"soft\">No effect was added to this model yet.</p>\n".into()
    } else {
        table("Error after each added effect, rms", &head, &[1, 2, 3, 4], &rows)
    };
    format!("<section><h2>Ladder</h2>\n{chart}{rows}</section>\n")
}

/// Start, every effect added, and the best candidate as a promise.
fn steps(input: &CompareInput) -> Vec<Bar> {
    let fit = &input.identification;
    let mut steps = Vec::new();
    match input.ladder.first() {
        Some(first) => {
            let (fit_um, holdout_um) = (first.fit_before_um, first.holdout_before_um);
            steps.push(Bar { name: "before anything was added".into(), fit_um, holdout_um });
        }
        None => steps.push(Bar {
            name: format!("now: {}", fit.effects.join(" + ")),
            fit_um: fit.rms_um,
            holdout_um: fit.holdout_rms_um,
        }),
    }
    steps.extend(input.ladder.iter().map(|row| Bar {
        name: format!("+ {}", row.effect),
        fit_um: row.fit_after_um,
        holdout_um: row.holdout_after_um,
    }));
    if let Some(best) = input.diagnosis.as_ref().and_then(|d| d.candidates.first()) {
        steps.push(Bar {
            name: format!("+ {} (proposed, not added yet)", best.effect),
            fit_um: best.rms_um_after,
            holdout_um: Some(best.holdout_rms_um_after),
        });
    }
    steps
}

fn row(row: &LadderRow) -> Vec<String> {
    let moved = row
        .largest_location_change
        .as_ref()
        .map_or(MISSING.into(), |(name, change, unit)| format!("{name} by {}", with_unit(*change, unit)));
    vec![
        row.effect.clone(),
        um(row.fit_before_um),
        um(row.fit_after_um),
        um_or_dash(row.holdout_before_um),
        um_or_dash(row.holdout_after_um),
        moved,
        row.date.clone(),
        row.run.clone(),
    ]
}
