//! Tables for the terminal: aligned columns, no colours, no line drawing beyond plain bars.

mod correction;
mod diagnosis;
mod filed;
mod findings;
mod history;
mod ladder;
mod live;
mod plan;
mod prediction;
mod table;
mod timing;
mod volumetric;

pub use correction::{correction_judged_text, correction_text};
pub use diagnosis::diagnosis_text;
pub use filed::report_text;
pub use findings::findings_text;
pub use history::history_text;
pub use ladder::ladder_text;
pub use live::{live_line, live_screen, nest_text, sign_test_text};
pub use plan::{plan_text, preview_text};
pub use prediction::prediction_text;
pub use timing::timing_text;
pub use volumetric::{location_text, volumetric_text};

use crate::number::{percent, um, um_or_dash, value_and_u};
use crate::views::cuts;
use crate::words::{
    NO_PLACE, effect_name, headline, no_place, noise_origin, not_judged, trial_verdict, verdict, wave,
};
use diagnosis::{held_out, what_to_do};
use std::iter::once;
use table::{bar, clean, columns, moved_table, paragraph, set_apart, titled, with_bars};
use trunnion_results::FEWEST_POINTS;
use trunnion_results::sentences::{complete, doubts, doubts_of, inadequate};
use trunnion_results::{
    Check, Comparison, Complete, Identification, Moved, Parameter, Place, Plausibility, Trial,
};

/// Fit, parameters with uncertainty, and what is confounded or not observable.
pub fn identification_text(view: &Identification) -> String {
    let mut out = format!("Machine {}, runs: {}\n", clean(&view.machine), clean(&view.runs.join(", ")));
    if !view.plausibility.is_empty() {
        out += &format!("{}\n", set_apart(&implausible(&view.plausibility)));
    }
    out += &absent(&view.complete);
    out += &format!("Model: {}\n\n", clean(&view.effects.join(" + ")));
    out += &columns(
        &[
            vec!["points".into(), points(view)],
            vec!["residual".into(), format!("{} rms", um(view.rms_um))],
            vec!["repeatability".into(), noise(view)],
            vec!["held-out".into(), held_out(view.holdout_rms_um, view.holdout_unit)],
        ],
        &[],
    );
    out += "\n";
    out += &inadequate(view).map_or(String::new(), |sentence| {
        paragraph(&format!("{sentence} Run `trunnion diagnose` with the same runs and model.")) + "\n"
    });
    out += &parameters(&view.listed());
    out += &another_run(view);
    out += &set_apart(&doubts(view));
    if !view.seen_together.is_empty() {
        out += "\nSeen only together\n";
        for row in &view.seen_together {
            let (value, u) = value_and_u(Some(row.value), Some(row.u), &row.unit);
            out += &format!("  {} = {value} (u {u})\n", clean(&row.combination));
        }
    }
    if !view.unobservable.is_empty() {
        out += "\nWhat these readings leave confounded\n";
        for row in &view.unobservable {
            out += &format!("  {}: {}\n", clean(&row.direction), clean(&row.why));
        }
    }
    out
}

/// What one more run will show of each parameter, where several runs show what differs between them.
fn another_run(view: &Identification) -> String {
    let rows = view.parameters.iter().filter_map(|p| {
        let (value, of_mean) = value_and_u(p.value, p.u, &p.unit);
        let (_, of_another) = value_and_u(p.value, Some(p.u_another_run?), &p.unit);
        Some(vec![p.name.clone(), value, of_mean, of_another])
    });
    let head =
        ["another run will show", "value", "u of the mean", "u of another run"].map(String::from).to_vec();
    let rows: Vec<_> = once(head).chain(rows).collect();
    if rows.len() > 1 { format!("\n{}", columns(&rows, &[1, 2, 3])) } else { String::new() }
}

/// Whether the runs can be what they say they are.
pub fn check_text(check: &Check) -> String {
    let head = format!("Runs: {}; {} usable points\n", clean(&check.runs.join(", ")), check.points);
    let head =
        head + &complete(&check.complete).iter().map(|sentence| paragraph(sentence)).collect::<String>();
    let head = head + &set_apart(&doubts_of(&check.doubts));
    match check.plausibility.is_empty() {
        true => head + &nothing_found(check),
        false => head + &set_apart(&implausible(&check.plausibility)),
    }
}

/// Where no mistake keeps the runs from being judged. What is doubted stands above: it goes on from there.
fn nothing_found(check: &Check) -> String {
    let none = if check.doubts.is_empty() { "No mistake" } else { "No other mistake" };
    let names = clean(&check.not_asked.join(", "));
    match (check.points < FEWEST_POINTS, check.not_asked.is_empty()) {
        (true, true) => paragraph(&format!(
            "The positions are possible. The readings were not asked: that needs {FEWEST_POINTS} points or more."
        )),
        (true, false) => paragraph(&format!(
            "The readings were not asked: that needs {FEWEST_POINTS} points or more. Whether the axes were at their positions was not asked \
             either: {names} keeps no known distance."
        )),
        (false, false) => paragraph(&format!(
            "{none} was found in readings and times. Whether the axes were at their positions was not asked: {names} keeps no known distance."
        )),
        (false, true) if check.doubts.is_empty() => {
            "Positions, readings and times fit together: no mistake was found.\n".into()
        }
        (false, true) => format!("{none} was found in positions, readings and times.\n"),
    }
}

fn points(view: &Identification) -> String {
    // Those of the fit: on the fly a cycle plans places, and a fit has blocks of samples.
    let read = view.complete.planned.map_or_else(String::new, |planned| {
        format!("; {} of {planned} planned were read", view.complete.read)
    });
    format!("{} in the fit ({} excluded){read}", view.points, view.outliers)
}

/// What is missing from the cycle and the recordings; nothing where all of it was read.
fn absent(found: &Complete) -> String {
    if found.planned.is_none_or(|planned| found.read == planned) && found.losses.is_empty() {
        return String::new();
    }
    complete(found).iter().map(|sentence| paragraph(sentence)).collect()
}

/// Why runs cannot be judged.
fn implausible(plausibility: &[Plausibility]) -> Vec<String> {
    plausibility.iter().map(|doubt| format!("Doubt: {} {}", doubt.finding, doubt.hypothesis)).collect()
}

/// What is wrong, what to do, where the model fails most, and the residual by component, axis position, direction, setup and time.
pub fn compare_text(input: &Comparison) -> String {
    let mut out = format!("{}\n", clean(&headline(input)));
    out += &paragraph(&verdict(input).join(" "));
    out += &what_to_do(input);
    out += "\nWhere the model fails most\n";
    out += &places(&input.places, no_place(input));
    let waves = input.spectra.iter().flat_map(|axis| axis.waves.iter().map(|one| wave(&axis.axis, one)));
    let waves = waves.chain(input.spectra.iter().filter_map(not_judged));
    let waves: String = waves.map(|sentence| paragraph(&sentence)).collect();
    if !waves.is_empty() {
        out += &format!("\nWhat repeats along the axes\n{waves}");
    }
    let cuts = cuts(&input.residuals);
    let mut rows = vec![["residual by", "", "readings", "rms"].map(String::from).to_vec()];
    let mut values = vec![f64::NAN];
    for (title, groups) in &cuts {
        for (i, group) in groups.iter().enumerate() {
            let title = if i == 0 { title.clone() } else { String::new() };
            rows.push(vec![title, group.name.clone(), group.points.to_string(), um(group.rms_um)]);
            values.push(group.rms_um);
        }
    }
    out += "\n";
    out += &columns(&with_bars(rows, &values), &[2, 3]);
    out += &absent(&input.identification.complete);
    out += &input.left_out.iter().map(|note| paragraph(note)).collect::<String>();
    out += &timing_text(&input.time_quality);
    out
}

/// What an effect put in for a trial does.
pub fn trial_text(trial: &Trial) -> String {
    let mut out = format!("Trying {}; the model file stays as it is\n", clean(&effect_name(&trial.effect)));
    if !trial.expression.is_empty() {
        out += &format!("  {}\n", clean(&trial.expression));
    }
    out += &paragraph(&trial_verdict(trial));
    let (rms, held_out) = (trial.rms_um, trial.holdout_rms_um);
    let figures = [rms.before, rms.after, held_out.before, held_out.after];
    let largest = figures.into_iter().flatten().fold(0.0, f64::max);
    let row = |name: &str, value: Option<f64>| {
        vec![name.into(), um_or_dash(value), value.map_or(String::new(), |value| bar(value, largest))]
    };
    out += "\n";
    out += &columns(
        &[
            row("fit before", rms.before),
            row("fit after", rms.after),
            row("held-out before", held_out.before),
            row("held-out after", held_out.after),
            row("repeatability", trial.noise_um),
        ],
        &[1],
    );
    for (when, list) in [("before", &trial.places.before), ("after", &trial.places.after)] {
        out += &format!("\nWhere the model fails most, {when}\n");
        out += &places(list, NO_PLACE);
    }
    out += "\n";
    out += &parameters(&trial.parameters);
    let moved: Vec<Moved> = trial.moved.iter().flatten().filter(|m| m.in_u() > 2.0).cloned().collect();
    if moved.is_empty() {
        out += "\nNo other parameter moves by more than 2 u.\n";
    } else {
        out += "\nOther parameters that it moves by more than 2 u\n";
        out += &moved_table(&moved);
    }
    out
}

fn parameters(rows: &[Parameter]) -> String {
    let head = ["parameter", "value", "u", "effect", "remark"].map(String::from).to_vec();
    let rows = rows.iter().map(|p| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        vec![p.name.clone(), value, u, p.effect.clone(), p.note.clone()]
    });
    titled(&once(head).chain(rows).collect::<Vec<_>>(), &[1, 2])
}

fn places(places: &[Place], none: &str) -> String {
    if places.is_empty() {
        return format!("  {none}\n");
    }
    let line = |(i, place): (usize, &Place)| {
        format!("  {}. {}; {} of the residual\n", i + 1, clean(&place.words), percent(place.share))
    };
    places.iter().enumerate().map(line).collect()
}

fn noise(fit: &Identification) -> String {
    let origin = clean(&noise_origin(fit));
    fit.noise_um.map_or(origin.clone(), |rms_um| format!("{} ({origin})", um(rms_um)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_results::{Doubt, DoubtReason, Question};

    /// What the terminal folds is a stretch of lines without an empty one.
    fn stand_alone(text: &str, count: usize) {
        let lists: Vec<&str> = text.split("\n\n").filter(|list| list.contains("Doubt: ")).collect();
        assert!(lists.len() == count && lists.iter().all(|list| list.trim().lines().count() == 1), "{text}");
    }

    #[test]
    fn what_is_planned_and_what_was_read_are_counted_in_the_same_way() {
        // A sweep: 140 places of its cycle, 1156 blocks in the fit.
        let complete = Complete { planned: Some(140), read: 140, ..Complete::default() };
        let text =
            identification_text(&Identification { points: 1156, complete, ..Identification::default() });
        assert!(!text.contains("1156 of 140") && text.contains("140 of 140 planned were read"), "{text}");
    }

    #[test]
    fn no_doubt_is_an_item_of_a_list_that_the_terminal_folds() {
        let doubt = |words: &str| Doubt {
            effect: None,
            names: Vec::new(),
            reason: DoubtReason::Scatter,
            words: words.into(),
        };
        let implausible = Plausibility {
            question: Question::Whole,
            finding: "10 of 144 points were read.".into(),
            hypothesis: String::new(),
            ..Plausibility::default()
        };
        let row = |name: &str| Parameter { name: name.into(), ..Parameter::default() };
        let view = Identification {
            parameters: vec![row("EX0C"), row("EY0C")],
            doubts: vec![doubt("one."), doubt("two.")],
            plausibility: vec![implausible.clone()],
            ..Identification::default()
        };
        stand_alone(&identification_text(&view), 3);
        let complete = Complete { planned: Some(144), read: 10, ..Complete::default() };
        let plausibility = vec![implausible.clone(), implausible];
        stand_alone(&check_text(&Check { complete, plausibility, ..Check::default() }), 2);
    }

    /// A doubt is a mistake that was found, also where something was not asked.
    #[test]
    fn below_a_doubt_no_other_mistake_was_found() {
        let doubt = Doubt::other_machine(["table-bc", "table-ac"]);
        for not_asked in [vec![], vec!["laser-tracker".to_string()]] {
            for (doubts, says) in [(vec![], false), (vec![doubt.clone()], true)] {
                let text = check_text(&Check {
                    points: 40,
                    doubts,
                    not_asked: not_asked.clone(),
                    ..Check::default()
                });
                assert_eq!(text.contains("No other mistake was found"), says, "{text}");
                assert!(!says || !text.to_lowercase().contains("no mistake"), "{text}");
            }
        }
        let few =
            check_text(&Check { not_asked: vec!["laser-tracker".into()], points: 3, ..Check::default() });
        assert!(!few.contains("positions are possible") && few.contains("not asked either"), "{few}");
    }
}
