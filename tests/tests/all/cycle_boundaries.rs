//! Where cycles begin and end, for each vocabulary of the controllers, against what the vocabulary says: written into
//! docs/measured/cycle-boundaries.md. Every NC program that is written goes through each of them too.

use crate::interpreter::{Event, interpret};
use std::fmt::Write;
use trunnion_acquire::execution::{VOCABULARIES, Vocabulary};
use trunnion_core::input::Document;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading};
use trunnion_core::{AxisValues, HostTime};
use trunnion_cycles::nc::{DIALECTS, Program};
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_machine::shipped;
use trunnion_sync::{Bound, CycleBounds, StartRule};
use trunnion_tests::section::write_or_compare;
use trunnion_tests::workspace_root;

const DOCUMENT: &str = "docs/measured/cycle-boundaries.md";

/// What happens at the machine, and how long each state lasts, s.
struct Story {
    name: &'static str,
    /// `[cycle_start]`.
    rule: &'static str,
    states: &'static [(f64, Shows)],
    /// Cycles that there are.
    cycles: usize,
}

/// What the controller shows: what the program does, its name, its block.
#[derive(Clone, Copy)]
struct Shows(What, &'static str, &'static str);

#[derive(Clone, Copy, PartialEq)]
enum What {
    Idle,
    Runs,
    /// M0.
    Stop,
    /// M1.
    OptionalStop,
    FeedHold,
    /// Emergency stop or alarm.
    Unasked,
    Completed,
    NoLink,
}

use What::{Completed, FeedHold, Idle, NoLink, OptionalStop, Runs, Stop, Unasked};

impl What {
    /// Words that a vocabulary has for it, best first; a controller without its own word for a hold goes on as it was.
    fn words(self) -> &'static [&'static str] {
        match self {
            Idle => &["READY", "5", "0", "idle", "IDLE"],
            Runs => &["ACTIVE", "3", "1", "running", "RUNNING"],
            Stop => &["PROGRAM_STOPPED", "2", "3", "interrupted", "PAUSED"],
            OptionalStop => &["OPTIONAL_STOP", "2", "3", "interrupted", "PAUSED"],
            FeedHold => &["FEED_HOLD", "2", "3", "feed_hold", "PAUSED"],
            Unasked => &["STOPPED", "5", "4", "stopped", "IDLE"],
            Completed => &["PROGRAM_COMPLETED", "5", "0", "completed", "IDLE"],
            NoLink => &["", "", "", "", ""],
        }
    }

    fn word(self, vocabulary: usize) -> &'static str {
        self.words()[vocabulary]
    }
}

const P: &str = "R-TEST";
const EXECUTION: &str = "";
const PROGRAM: &str = "[cycle_start]\nby = \"program\"\nprogram = \"R-TEST*\"\n";
const BLOCK: &str = "[cycle_start]\nby = \"block\"\nbegin = \"*CYCLE BEGIN*\"\nend = \"*CYCLE END*\"\n";

const STORIES: [Story; 14] = [
    Story {
        name: "a program runs to its end",
        rule: EXECUTION,
        states: &[(1.0, Shows(Idle, "", "")), (60.0, Shows(Runs, P, "N1")), (5.0, Shows(Completed, P, ""))],
        cycles: 1,
    },
    Story {
        name: "M0 for a quarter of an hour",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (900.0, Shows(Stop, P, "N50")),
            (60.0, Shows(Runs, P, "N51")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 1,
    },
    Story {
        name: "M1",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (30.0, Shows(OptionalStop, P, "N50")),
            (60.0, Shows(Runs, P, "N51")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 1,
    },
    Story {
        name: "feed hold over lunch",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (3600.0, Shows(FeedHold, P, "N50")),
            (60.0, Shows(Runs, P, "N50")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 1,
    },
    Story {
        name: "feed hold, reset, start 0.4 s later",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (5.0, Shows(FeedHold, P, "N50")),
            (0.4, Shows(Idle, P, "")),
            (60.0, Shows(Runs, P, "N1")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 2,
    },
    Story {
        name: "emergency stop, reset, start",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (20.0, Shows(Unasked, P, "N50")),
            (1.0, Shows(Idle, P, "")),
            (60.0, Shows(Runs, P, "N1")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 2,
    },
    Story {
        name: "alarm, start from the top, no reset shown",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (30.0, Shows(Runs, P, "N1")),
            (30.0, Shows(Runs, P, "N50")),
            (20.0, Shows(Unasked, P, "N50")),
            (60.0, Shows(Runs, P, "N1")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 2,
    },
    Story {
        name: "end and start 0.4 s later",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (0.4, Shows(Completed, P, "")),
            (60.0, Shows(Runs, P, "N1")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 2,
    },
    Story {
        name: "a main program calls the cycle twice (`by = \"program\"`)",
        rule: PROGRAM,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (5.0, Shows(Runs, "MAIN", "N1")),
            (60.0, Shows(Runs, P, "N1")),
            (0.4, Shows(Runs, "MAIN", "N2")),
            (60.0, Shows(Runs, P, "N1")),
            (1.0, Shows(Runs, "MAIN", "N3")),
            (1.0, Shows(Completed, "MAIN", "")),
        ],
        cycles: 2,
    },
    Story {
        name: "the cycle calls a subprogram (`by = \"program\"`)",
        rule: PROGRAM,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (30.0, Shows(Runs, P, "N1")),
            (5.0, Shows(Runs, "L100", "N1")),
            (30.0, Shows(Runs, P, "N9")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 1,
    },
    Story {
        name: "two cycles in one program (`by = \"block\"`)",
        rule: BLOCK,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (1.0, Shows(Runs, P, "MSG(\"CYCLE BEGIN\")")),
            (60.0, Shows(Runs, P, "N2")),
            (0.4, Shows(Runs, P, "MSG(\"CYCLE END\")")),
            (1.0, Shows(Runs, P, "MSG(\"CYCLE BEGIN\")")),
            (60.0, Shows(Runs, P, "N2")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 2,
    },
    Story {
        name: "the connection is lost for a minute",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (60.0, Shows(NoLink, "", "")),
            (60.0, Shows(Runs, P, "N50")),
            (1.0, Shows(Completed, P, "")),
        ],
        cycles: 1,
    },
    Story {
        name: "the service starts while the program runs",
        rule: EXECUTION,
        states: &[(60.0, Shows(Runs, P, "N50")), (1.0, Shows(Completed, P, ""))],
        cycles: 1,
    },
    Story {
        name: "an alarm that nobody clears",
        rule: EXECUTION,
        states: &[
            (1.0, Shows(Idle, "", "")),
            (60.0, Shows(Runs, P, "N1")),
            (600.0, Shows(Unasked, P, "N50")),
        ],
        cycles: 1,
    },
];

fn at(time_s: f64) -> HostTime {
    HostTime((time_s * 1e9) as i64)
}

fn controller(time_s: f64, vocabulary: usize, Shows(what, program, block): Shows) -> Reading {
    Reading::Controller(ControllerReading {
        execution: VOCABULARIES[vocabulary].execution(what.word(vocabulary)),
        program: program.into(),
        block: block.into(),
        signal: None,
        stamp_ns: 0,
        arrival: at(time_s),
    })
}

fn axes(time_s: f64) -> Reading {
    Reading::Axes(AxisReading {
        stamp_ns: 0,
        arrival: at(time_s),
        position: AxisValues::default(),
        present: AxisValues::from_fn(|_| true),
        sequence: 0,
        held: false,
        skew_ns: 0,
    })
}

fn rule(text: &str) -> StartRule {
    let document = Document::parse("t.toml", text).unwrap();
    let root = document.root();
    let rule = StartRule::read(&root);
    drop(root);
    document.finish(rule).unwrap()
}

/// Begins and ends of a story, s after its beginning.
fn bounds(story: &Story, vocabulary: usize) -> Vec<(f64, bool)> {
    let mut bounds = CycleBounds::new(rule(story.rule));
    let (mut found, mut time_s) = (Vec::new(), 0.0);
    for (seconds, shows) in story.states {
        let readings = std::iter::once(controller(time_s, vocabulary, *shows))
            .chain((1..*seconds as usize).map(|k| axes(time_s + k as f64)));
        for bound in readings.filter_map(|reading| bounds.take(&reading)) {
            found.push(match bound {
                Bound::Begins { at, .. } => (at.0 as f64 * 1e-9, true),
                Bound::Ends { at, .. } => (at.0 as f64 * 1e-9, false),
            });
        }
        time_s += seconds;
    }
    found
}

#[test]
fn every_story_of_the_shop_floor_has_its_cycles_in_every_vocabulary() {
    let names: Vec<&str> = VOCABULARIES.iter().map(|vocabulary| vocabulary.name).collect();
    let mut table = format!(
        "| what happens | cycles | {} |\n|---|---|{}\n",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    let mut wrong = Vec::new();
    for story in &STORIES {
        write!(table, "| {} | {} |", story.name, story.cycles).unwrap();
        for vocabulary in 0..VOCABULARIES.len() {
            let found = bounds(story, vocabulary);
            let begins = found.iter().filter(|(_, begins)| *begins).count();
            if begins != story.cycles {
                wrong.push(format!("{} in {}: {found:?}", story.name, names[vocabulary]));
            }
            let times = found.iter().map(|(s, begins)| format!("{}{s:.1}", if *begins { "▸" } else { "◂" }));
            write!(table, " {} |", times.collect::<Vec<_>>().join(" ")).unwrap();
        }
        table.push('\n');
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    write_or_compare(DOCUMENT, "stories", &table);
}

#[test]
fn the_words_of_every_vocabulary_are_in_the_document() {
    let words: String = VOCABULARIES.iter().map(|vocabulary| words(vocabulary)).collect();
    write_or_compare(DOCUMENT, "words", &words);
}

fn words(vocabulary: &Vocabulary) -> String {
    let effect = |means| match means {
        Execution::Unknown => "nothing",
        Execution::Ready | Execution::Ended => "ends a cycle; what runs next is another",
        Execution::Active => "begins a cycle, or goes on with it",
        Execution::Held => "nothing, however long",
        Execution::Stopped => "nothing yet: what comes next decides, or 120 s",
    };
    let mut text = format!(
        "### {}\n\nSource: {}.\n\n| word | says | means | does |\n|---|---|---|---|\n",
        vocabulary.name, vocabulary.source
    );
    for word in vocabulary.words {
        let means = format!("{:?}", word.means).to_lowercase();
        writeln!(text, "| `{}` | {} | {means} | {} |", word.word, word.definition, effect(word.means))
            .unwrap();
    }
    text + "\n"
}

/// Programs of every shipped cycle that has one, in every dialect, with an operator at every stop.
#[test]
fn every_program_that_is_written_is_one_cycle_in_every_vocabulary() {
    let mut programs = 0;
    for entry in std::fs::read_dir(workspace_root().join("config/cycles")).unwrap() {
        let path = entry.unwrap().path();
        let cycle = Cycle::parse("c.toml", &std::fs::read_to_string(&path).unwrap()).unwrap();
        let Some(machine) = shipped::machine(&cycle.machine).filter(|machine| machine.tripod.is_none())
        else {
            continue;
        };
        let Ok(program) = Program::of_cycle(&cycle, &machine, &CourseRules::default()) else { continue };
        for dialect in DIALECTS {
            let events = interpret(dialect.name, &(dialect.write)(&program, dialect.decimals));
            programs += 1;
            for vocabulary in 0..VOCABULARIES.len() {
                let mut bounds = CycleBounds::new(StartRule::Execution);
                let (mut found, mut time_s) = (Vec::new(), 1.0);
                let mut show = |time_s, what| {
                    found.extend(bounds.take(&controller(time_s, vocabulary, Shows(what, P, ""))));
                };
                show(0.0, Idle);
                show(time_s, Runs);
                for event in &events {
                    match event {
                        Event::Move { seconds, .. } | Event::Dwell { seconds } => time_s += seconds,
                        Event::Stop(_) => {
                            show(time_s, Stop);
                            time_s += 600.0;
                            show(time_s, Runs);
                        }
                    }
                }
                show(time_s, Completed);
                let is_one = matches!(&found[..], [Bound::Begins { .. }, Bound::Ends { .. }]);
                assert!(
                    is_one,
                    "{} {} {}: {found:?}",
                    path.display(),
                    dialect.name,
                    VOCABULARIES[vocabulary].name
                );
            }
        }
    }
    assert!(programs > 20, "{programs}");
}
