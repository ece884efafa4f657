//! Tables for the terminal: aligned columns, no colours, no line drawing beyond plain bars.

use crate::number::{percent, um, um_or_dash, value_and_u, with_unit};
use crate::views::{cuts, worst_places};
use crate::words::{candidate_figures, effect_name, explanation, headline, verdict_sentence};
use crate::{CompareInput, IdentificationView, LadderRow, Noise};
use std::iter::once;
use trunnion_diagnose::Diagnosis;

/// Longest bar, characters.
const BAR: f64 = 30.0;

/// Fit, parameters with uncertainty, and what cannot be told apart.
pub fn identification_text(view: &IdentificationView) -> String {
    let mut out = format!("Machine {}, runs: {}\n", clean(&view.machine), clean(&view.runs.join(", ")));
    out += &format!("Model: {}\n\n", clean(&view.effects.join(" + ")));
    out += &columns(
        &[
            vec!["points".into(), format!("{} ({} set aside)", view.points, view.outliers)],
            vec!["error left".into(), format!("{} rms", um(view.rms_um))],
            vec!["noise floor".into(), noise(&view.noise)],
            vec!["held-out".into(), um_or_dash(view.holdout_rms_um)],
        ],
        &[],
    );
    out += "\n";
    let head = ["parameter", "value", "u", "effect", "remark"].map(String::from).to_vec();
    let rows = view.parameters.iter().map(|p| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        vec![p.name.clone(), value, u, p.effect.clone(), p.note.clone()]
    });
    out += &columns(&once(head).chain(rows).collect::<Vec<_>>(), &[1, 2]);
    if !view.unobservable.is_empty() {
        out += "\nWhat these readings cannot tell apart\n";
        for row in &view.unobservable {
            out += &format!("  {}: {}\n", clean(&row.direction), clean(&row.why));
        }
    }
    out
}

/// Where the model fails: residual by axis position, direction, setup, time and component.
pub fn compare_text(input: &CompareInput) -> String {
    let mut out = format!("{}\n\n", clean(&headline(input)));
    let places = worst_places(input);
    if !places.is_empty() {
        out += "Where the model fails most\n";
        for (i, place) in places.iter().enumerate() {
            out += &format!("  {}. {}\n", i + 1, clean(place));
        }
    }
    let cuts = cuts(input);
    let groups = cuts.iter().flat_map(|(_, groups)| groups);
    let largest = groups.map(|group| group.rms_um).filter(|r| r.is_finite()).fold(0.0, f64::max);
    let mut rows = vec![["residual by", "", "readings", "rms", ""].map(String::from).to_vec()];
    for (title, groups) in &cuts {
        for (i, group) in groups.iter().enumerate() {
            let title = if i == 0 { title.clone() } else { String::new() };
            let bar = bar(group.rms_um, largest);
            rows.push(vec![title, group.name.clone(), group.points.to_string(), um(group.rms_um), bar]);
        }
    }
    out += "\n";
    out += &columns(&rows, &[2, 3]);
    for loss in &input.losses {
        out += &format!("\nData loss: {}\n", clean(loss));
    }
    out
}

/// Verdict, candidates, formula and what to measure next.
pub fn diagnosis_text(diagnosis: &Diagnosis) -> String {
    let residual = &diagnosis.residual;
    let mut out = format!("{}\n", clean(&verdict_sentence(diagnosis, residual.rms_um)));
    out += &format!("Above the noise: {} of the mean square.\n", percent(residual.unexplained_fraction));
    if !diagnosis.candidates.is_empty() {
        out += "\n";
        let head = ["candidate", "evidence", "error after", "held-out", "explains", "enough", "alike here"];
        let rows = diagnosis.candidates.iter().map(|c| {
            vec![
                c.effect.clone(),
                format!("10^{:.1}", c.evidence),
                um(c.rms_um_after),
                um(c.holdout_rms_um_after),
                percent(c.explains_fraction),
                if c.adequate { "yes" } else { "no" }.into(),
                c.confused_with.join(", "),
            ]
        });
        let rows: Vec<_> = once(head.map(String::from).to_vec()).chain(rows).collect();
        out += &columns(&rows, &[1, 2, 3, 4]);
    }
    if let Some(best) = diagnosis.candidates.first() {
        out += &format!(
            "\n{}\n  {}\n  {}\n",
            effect_name(&best.effect),
            clean(&best.why),
            candidate_figures(best)
        );
        for (label, text) in explanation(&best.effect) {
            out += &format!("  {label}: {text}\n");
        }
        for p in &best.parameters {
            let (value, u) = value_and_u(p.value, p.u, &p.unit);
            out += &format!("  {} = {value}, u = {u}\n", clean(&p.name));
        }
        if !best.confused_with.is_empty() {
            out += &format!(
                "  Cannot well be told from {}. To separate them: {}\n",
                clean(&best.confused_with.join(", ")),
                clean(&best.separate_by)
            );
        }
    }
    if let Some(formula) = &diagnosis.formula {
        out += &format!(
            "\nformula:{} at {}, {}\n  {}\n  it lives {}; leaves {}, explains {}\n",
            clean(&formula.name),
            clean(&formula.site),
            clean(&formula.component),
            clean(&formula.expression),
            clean(&formula.lives),
            um(formula.rms_um_after),
            percent(formula.explains_fraction)
        );
    }
    if let Some(next) = &diagnosis.next_cycle {
        out += &format!("\nMeasure next: {}\n", clean(&next.suggestion));
    }
    for (words, ids) in
        [("This cycle cannot show", &diagnosis.not_visible), ("Out of reach", &diagnosis.out_of_reach)]
    {
        if !ids.is_empty() {
            out += &format!("\n{words}: {}\n", clean(&ids.join(", ")));
        }
    }
    out
}

/// The ladder as a table with bars; `noise_um` is the noise floor where known.
pub fn ladder_text(rows: &[LadderRow], noise_um: Option<f64>) -> String {
    let Some(first) = rows.first() else { return "No effect was added to this model yet.\n".into() };
    let fits = rows.iter().map(|row| row.fit_after_um).chain(once(first.fit_before_um)).chain(noise_um);
    let largest = fits.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let mut table = vec![["added", "fit", "held-out", "", "moved most"].map(String::from).to_vec()];
    let step = |name: String, fit_um: f64, holdout_um: Option<f64>, moved: String| {
        vec![name, um(fit_um), um_or_dash(holdout_um), bar(fit_um, largest), moved]
    };
    table.push(step("(before)".into(), first.fit_before_um, first.holdout_before_um, String::new()));
    for row in rows {
        let moved = row.largest_location_change.as_ref();
        let moved =
            moved.map_or(String::new(), |(name, by, unit)| format!("{name} {}", with_unit(*by, unit)));
        table.push(step(format!("+ {}", row.effect), row.fit_after_um, row.holdout_after_um, moved));
    }
    if let Some(noise_um) = noise_um {
        table.push(step("(noise floor)".into(), noise_um, None, String::new()));
    }
    columns(&table, &[1, 2])
}

fn noise(noise: &Noise) -> String {
    match noise.rms_um {
        Some(rms_um) => format!("{} ({})", um(rms_um), clean(&noise.origin)),
        None => clean(&noise.origin),
    }
}

fn bar(value: f64, largest: f64) -> String {
    let share = value / largest;
    if share.is_finite() { "#".repeat((share * BAR).round().clamp(0.0, BAR) as usize) } else { String::new() }
}

/// Columns two blanks apart; those in `right` are aligned right.
fn columns(rows: &[Vec<String>], right: &[usize]) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| clean(cell)).collect()).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |j: usize| rows.iter().filter_map(|row| row.get(j)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut out = String::new();
    for row in &rows {
        let cells = row.iter().enumerate().map(|(j, cell)| match right.contains(&j) {
            true => format!("{cell:>width$}", width = widths[j]),
            false => format!("{cell:<width$}", width = widths[j]),
        });
        out += cells.collect::<Vec<_>>().join("  ").trim_end();
        out.push('\n');
    }
    out
}

/// One line without control characters: a name cannot move the cursor or colour the terminal.
fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
