//! docs/measured/faults.md from the cells.

use super::matrix::{Case, Cell, GapOf, Lost, Subject, Trouble};
use trunnion_tests::section::write_or_compare;

/// Compares the file with the cells, or writes it when TRUNNION_WRITE_DOCS is set.
pub fn check(subjects: &[&Subject]) {
    write_or_compare("docs/measured/faults.md", "fault_matrix", &tables(subjects));
}

fn tables(subjects: &[&Subject]) -> String {
    let mut text = overview(subjects);
    for subject in subjects {
        text += &format!(
            "\n## `{}`: {}\n\n| fault | state | recorded gap | readings missing | message |\n|---|---|---|---|---|\n",
            subject.driver, subject.about
        );
        for trouble in Trouble::ALL {
            if let Cell::Case(case) = subject.cell(trouble) {
                text += &row(trouble, &case);
            }
        }
    }
    text
}

/// Device × fault; why a cell is empty stands below.
fn overview(subjects: &[&Subject]) -> String {
    let names: Vec<&str> = Trouble::ALL.iter().map(|trouble| trouble.name()).collect();
    let mut text = format!("\n| | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(names.len()));
    let mut reasons: Vec<&'static str> = Vec::new();
    for subject in subjects {
        text += &format!("| `{}` |", subject.driver);
        for trouble in Trouble::ALL {
            match subject.cell(trouble) {
                Cell::Case(_) => text += " pass |",
                Cell::Cannot(why) => {
                    let known = reasons.iter().position(|reason| *reason == why);
                    let index = known.unwrap_or(reasons.len());
                    if known.is_none() {
                        reasons.push(why);
                    }
                    text += &format!(" — ({}) |", index + 1);
                }
            }
        }
        text += "\n";
    }
    text += "\n";
    for (index, reason) in reasons.iter().enumerate() {
        text += &format!("{}. {reason}\n", index + 1);
    }
    text
}

fn row(trouble: Trouble, case: &Case) -> String {
    let states: Vec<String> = case.course.iter().map(|state| format!("{state:?}")).collect();
    let mut states = if states.is_empty() { "Streaming".to_owned() } else { states.join(" → ") };
    if let Some((state, when)) = case.perhaps {
        states += &format!("; also {state:?} where {when}");
    }
    let (gap, lost) =
        case.gap.as_ref().map_or(("none".to_owned(), ""), |gap| (shown_gap(gap), shown_lost(gap.lost)));
    format!("| {} | {states} | {gap} | {lost} | {} |\n", trouble.name(), shown(&case.message))
}

fn shown_gap(gap: &GapOf) -> String {
    let channel = gap.channel.map_or(String::new(), |channel| format!("{channel}: "));
    format!("{channel}{}", shown(&gap.reason))
}

fn shown_lost(lost: Lost) -> &'static str {
    match lost {
        Lost::NotCounted => "time only",
        Lost::Exactly(_) | Lost::Counted => "counted",
    }
}

fn shown(text: &str) -> String {
    text.replace('*', "…").replace('|', "\\|")
}
