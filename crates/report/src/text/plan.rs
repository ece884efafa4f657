//! The next cycle, and what a cycle shows, for the terminal.

use super::table::columns;
use trunnion_core::number::odds;
use trunnion_results::{Goal, OutOfReach, Plan, Preview, SeenBy};

/// The answer, the cycles considered, and what was assumed.
pub fn plan_text(plan: &Plan) -> String {
    let mut text = format!("{}\n", plan.answer);
    let separates = plan.goal == Goal::Separate;
    if separates {
        text += &format!(
            "\nTo separate: {}. In the present data: odds {}.\n",
            plan.effects.join(", "),
            odds(plan.separation_before)
        );
    } else if !plan.effects.is_empty() {
        text += &format!("\nNot seen so far: {}.\n", plan.effects.join(", "));
    }
    if !plan.considered.is_empty() {
        text += "\nConsidered\n";
        text += &if separates { separating(plan) } else { revealing(plan) };
    }
    if !plan.never_shown.is_empty() {
        text += &format!("\nNo cycle considered shows: {}.\n", plan.never_shown.join(", "));
    }
    text += "\nAssumed\n";
    for line in &plan.assumptions {
        text += &format!("  {line}\n");
    }
    text
}

fn separating(plan: &Plan) -> String {
    let pairs = plan.effects.len() * (plan.effects.len() - 1) / 2;
    let head =
        ["cycle", "minutes", "pairs separated", "odds after", "hardest pair", "what"].map(String::from);
    let rows = plan.considered.iter().map(|row| {
        [
            row.name.clone(),
            format!("{:.1}", row.minutes),
            format!("{}/{pairs}", row.pairs_apart),
            odds(row.separation),
            row.hardest_pair.join(" / "),
            row.what.clone(),
        ]
    });
    table(&std::iter::once(head).chain(rows).collect::<Vec<_>>())
}

fn revealing(plan: &Plan) -> String {
    let head = ["cycle", "minutes", "shows", "separates", "what"].map(String::from);
    let rows = plan.considered.iter().map(|row| {
        [
            row.name.clone(),
            format!("{:.1}", row.minutes),
            format!("{}/{}", row.shows.len(), plan.effects.len()),
            format!("{}/{}", row.separates.len(), plan.effects.len()),
            row.what.clone(),
        ]
    });
    table(&std::iter::once(head).chain(rows).collect::<Vec<_>>())
}

/// What a cycle shows, and what is confounded in it.
pub fn preview_text(preview: &Preview) -> String {
    let mut text = format!(
        "Cycle {}: {} points, about {:.0} minutes with mounting.\n\nIt shows: {}.\n",
        preview.cycle,
        preview.points,
        preview.minutes,
        preview.visible.join(", ")
    );
    let seen = |row: &SeenBy| [row.effect.clone(), format!("seen by: {}", row.seen_by)];
    let needs = |row: &OutOfReach| [row.effect.clone(), row.why.clone()];
    for (title, list) in [
        (
            "It cannot show, because location errors and ball settings imitate them",
            preview.invisible.iter().map(seen).collect::<Vec<_>>(),
        ),
        ("Out of reach in it", preview.out_of_reach.iter().map(needs).collect()),
    ] {
        if !list.is_empty() {
            text += &format!("\n{title}\n");
            text += &table(&list);
        }
    }
    if !preview.aliases.is_empty() {
        text += "\nConfounded in it\n";
        let rows: Vec<[String; 4]> = preview
            .aliases
            .iter()
            .map(|alias| {
                let apart = match &alias.separated_by {
                    Some(by) => format!("separated by {} ({:.0} min)", by.name, by.minutes),
                    None => "no cycle considered separates them".into(),
                };
                [
                    alias.one.clone(),
                    alias.other.clone(),
                    format!(
                        "{} of {}",
                        alias.shared_directions,
                        alias.directions[0].min(alias.directions[1])
                    ),
                    apart,
                ]
            })
            .collect();
        text += &table(&rows);
    }
    text
}

/// Indented columns.
fn table<const N: usize>(rows: &[[String; N]]) -> String {
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.to_vec()).collect();
    columns(&rows, &[]).lines().map(|line| format!("  {line}\n")).collect()
}
