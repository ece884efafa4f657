//! Durations that the guide states are those of the programs.

use crate::section::is_writing;
use trunnion_cycles::nc::Program;
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_machine::shipped;

/// The guide to the schemes gives the duration of the NC program, as its header does; of what has none, that of the cycle without mounting.
#[test]
fn the_guide_gives_the_durations_of_the_programs() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/use/schemes.md");
    let text = std::fs::read_to_string(path).unwrap();
    let (mut written, mut rest, mut count) = (String::new(), text.as_str(), 0);
    while let Some(at) = rest.find("` (") {
        let name = rest[..at].rsplit('`').next().unwrap();
        let (before, after) = rest.split_at(at + 3);
        written += before;
        rest = after;
        let Some(end) = after
            .find(" min")
            .filter(|&end| after[..end].chars().all(|c| c.is_ascii_digit() || c == 'h' || c == ' '))
        else {
            continue;
        };
        let minutes = minutes(name);
        written += &match minutes / 60 {
            0 => minutes.to_string(),
            hours => format!("{hours} h {}", minutes % 60),
        };
        rest = &after[end..];
        count += 1;
    }
    written += rest;
    if is_writing() {
        std::fs::write(path, &written).unwrap();
        return;
    }
    assert!(count > 20, "{count}");
    assert_eq!(text, written, "docs/use/schemes.md is old: run this test with TRUNNION_WRITE_DOCS=1");
}

/// Whole minutes of a shipped cycle.
fn minutes(name: &str) -> u32 {
    let path = format!("{}/../../config/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let cycle = Cycle::parse(&path, &text).unwrap();
    let (machine, rules) = (shipped::machine(&cycle.machine).unwrap(), CourseRules::default());
    let seconds = match cycle.touches() || cycle.named_joint().is_some() {
        false => Program::of_cycle(&cycle, &machine, &rules).unwrap().duration_s,
        true => {
            let visits = cycle.visits(&machine, &rules.pace).unwrap().states;
            visits.iter().filter_map(|state| state.time_s).fold(0.0, f64::max) - mounting_s(&cycle, &rules)
        }
    };
    (seconds / 60.0).ceil() as u32
}

/// What a cycle takes between its first and its last reading to mount the next setup, s.
fn mounting_s(cycle: &Cycle, rules: &CourseRules) -> f64 {
    if cycle.rounds.interleave || cycle.setups.len() == 1 {
        return 0.0;
    }
    let changes = (cycle.setups.len() * cycle.rounds.count).saturating_sub(1);
    changes as f64 * rules.pace.mount_s
}
