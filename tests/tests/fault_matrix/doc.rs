//! docs/faults.md from the cells.

use crate::matrix::{Case, Cell, GapOf, Lost, Subject, Trouble};
use trunnion_tests::workspace_root;

const BEGIN: &str = "<!-- written by the test fault_matrix from here -->\n";
const END: &str = "<!-- to here -->\n";

/// Compares the file with the cells, or writes it when TRUNNION_WRITE_DOCS is set.
pub fn check(subjects: &[&Subject]) {
    let path = workspace_root().join("docs/faults.md");
    let text = std::fs::read_to_string(&path).expect("docs/faults.md can be read");
    let (before, rest) = text.split_once(BEGIN).expect("docs/faults.md has the begin mark");
    let (_, after) = rest.split_once(END).expect("docs/faults.md has the end mark");
    let current = format!("{before}{BEGIN}{}{END}{after}", tables(subjects));
    if std::env::var_os("TRUNNION_WRITE_DOCS").is_some() {
        std::fs::write(&path, current).expect("docs/faults.md can be written");
        return;
    }
    assert!(text == current, "docs/faults.md is old: run this test with TRUNNION_WRITE_DOCS=1");
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
