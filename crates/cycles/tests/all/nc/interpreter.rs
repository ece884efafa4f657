//! Just enough of each dialect to run the programs: positions in mm and degrees, durations in s.

use std::collections::HashMap;
use trunnion_core::{AxisValues, Joint};

/// What a program does.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Straight to a position.
    Move { to: AxisValues<f64>, seconds: f64 },
    /// Stands still.
    Dwell { seconds: f64 },
    /// Waits for the operator.
    Stop(String),
}

/// Runs a program that moves every axis itself; what the dialect does not know fails.
pub fn interpret(dialect: &str, text: &str) -> Vec<Event> {
    let run = run(dialect, text);
    assert!(run.iter().all(|(_, keeps)| !keeps), "tool centre point control is on");
    run.into_iter().map(|(event, _)| event).collect()
}

/// What a program does, and whether tool centre point control is on: positions are then of the tool point over the table.
pub fn run(dialect: &str, text: &str) -> Vec<(Event, bool)> {
    match dialect {
        "fanuc" => iso(&fanuc_lines(text), 1e-3, 'P'),
        "linuxcnc" => iso(&linuxcnc_lines(text), 1.0, 'P'),
        "siemens" => iso(&siemens_lines(text), 1.0, 'F'),
        "heidenhain" => klartext(text),
        other => panic!(
            "crates/cycles/tests/all/nc/interpreter.rs, `interpret`: add a line for {other}: where its blocks are letters and numbers, \
             its lines, the unit of a dwell in seconds and the letter of the dwell; else a reader like `klartext`"
        ),
    }
}

/// Capital letters, and no colon, which would be read as the letter O of a program number.
fn fanuc_lines(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!((lines[0], lines[lines.len() - 1]), ("%", "%"));
    assert!(lines[1].starts_with('O') && lines[1][1..5].parse::<u32>().is_ok(), "{}", lines[1]);
    assert!(
        !text.contains(':') && text.to_ascii_uppercase() == text,
        "Fanuc takes capital letters and no colon"
    );
    bracketed(text.lines())
}

fn linuxcnc_lines(text: &str) -> Vec<String> {
    bracketed(text.lines())
}

/// Blocks of a program whose comments stand in brackets on lines of their own, without `%` and the number of the program.
fn bracketed<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut blocks = Vec::new();
    for line in lines.filter(|line| *line != "%" && !line.starts_with('O')) {
        if let Some(comment) = line.strip_prefix('(') {
            let inner = comment.strip_suffix(')').expect("a comment fills its line");
            assert!(!inner.contains(['(', ')']), "nested comment: {line}");
        } else {
            blocks.push(line.to_owned());
        }
    }
    blocks
}

fn siemens_lines(text: &str) -> Vec<String> {
    let known = ["ORIMKS", "MSG("];
    text.lines()
        .filter(|line| !line.starts_with("; ") && !known.iter().any(|word| line.starts_with(word)))
        .map(|line| line.split(" CTOL=").next().unwrap().to_owned())
        .collect()
}

/// Blocks of letters and numbers. `dwell_unit_s` is the unit of a G4 with `dwell_word`.
fn iso(lines: &[String], dwell_unit_s: f64, dwell_word: char) -> Vec<(Event, bool)> {
    let mut events = Vec::new();
    let mut keeps = false;
    let (mut at, mut known) = (AxisValues::<f64>::default(), AxisValues::<bool>::default());
    let (mut inverse_time, mut ended) = (false, false);
    for line in lines {
        assert!(!ended, "something after the end: {line}");
        if let "TRAORI" | "TRAFOOF" = line.as_str() {
            keeps = line == "TRAORI";
            continue;
        }
        let words: Vec<(char, f64)> = line
            .split_whitespace()
            .map(|word| {
                let number = word[1..].parse().unwrap_or_else(|_| panic!("no number in {word} of {line}"));
                (word.chars().next().unwrap(), number)
            })
            .collect();
        let codes: Vec<i64> = words.iter().filter(|w| w.0 == 'G').map(|w| (w.1 * 10.0) as i64).collect();
        let others: HashMap<char, f64> = words.iter().copied().filter(|w| w.0 != 'G').collect();
        for code in &codes {
            match code {
                930 => inverse_time = true,
                940 => inverse_time = false,
                // G43.4 with the places where the axes stand.
                434 => {
                    let stand = |l: &Joint| others.get(&l.as_str().chars().next().unwrap()) == Some(&at[*l]);
                    assert!(Joint::LINEAR.iter().all(stand) && others[&'H'] == 1.0, "{line} moves");
                    keeps = true;
                }
                430 => assert_eq!(others[&'H'], 1.0, "{line}"),
                10 | 40 | 170 | 210 | 400 | 490 | 540 | 640 | 800 | 900 | 6420 | 7100 => {}
                other => panic!(
                    "G{} in {line}: no code of the list above, which changes no position and no time",
                    *other as f64 / 10.0
                ),
            }
        }
        if codes.contains(&40) {
            events.push((Event::Dwell { seconds: others[&dwell_word] * dwell_unit_s }, keeps));
            continue;
        }
        match others.get(&'M').map(|m| *m as i64) {
            Some(0) => events.push((Event::Stop(String::new()), keeps)),
            Some(2 | 30) => ended = true,
            Some(other) => panic!("M{other} in {line}: only M0, M2 and M30 are read"),
            None => {}
        }
        if codes.contains(&10) {
            let target: Vec<(Joint, f64)> = Joint::ALL
                .into_iter()
                .filter_map(|letter| {
                    others.get(&letter.as_str().chars().next().unwrap()).map(|v| (letter, *v))
                })
                .collect();
            let feed = others[&'F'];
            assert!(feed > 0.0 && !target.is_empty(), "{line}");
            let seconds = if inverse_time { 60.0 / feed } else { way(&at, &known, &target) / feed * 60.0 };
            go(&mut at, &mut known, &target);
            events.push((Event::Move { to: at, seconds }, keeps));
        }
    }
    assert!(ended, "the program does not end");
    events
}

fn klartext(text: &str) -> Vec<(Event, bool)> {
    let mut events = Vec::new();
    let mut keeps = false;
    let (mut at, mut known) = (AxisValues::<f64>::default(), AxisValues::<bool>::default());
    let count = text.lines().count();
    let mut cycle = 0;
    for (i, line) in text.lines().enumerate() {
        let (number, block) = line.split_once(' ').unwrap();
        assert_eq!(number.parse(), Ok(i), "block numbers");
        if i == 0 || i + 1 == count {
            assert!(
                block.starts_with(["BEGIN PGM ", "END PGM "][usize::from(i > 0)]) && block.ends_with(" MM")
            );
        } else if let Some(rest) = block.strip_prefix("CYCL DEF ") {
            let words: Vec<&str> = rest.split(' ').collect();
            match words[..] {
                ["9.0", "DWELL", "TIME"] => cycle = 9,
                ["9.1", "DWELL", seconds] => {
                    assert_eq!(cycle, 9);
                    events.push((Event::Dwell { seconds: seconds.parse().unwrap() }, keeps));
                }
                ["32.0", "TOLERANCE"] | ["32.1"] => {}
                ["32.1", tolerance] => assert!(tolerance[1..].parse::<f64>().unwrap() > 0.0),
                _ => panic!("{line}"),
            }
        } else if let Some(rest) = block.strip_prefix("L ") {
            let (axes, feed) = rest.split_once(" R0 F").unwrap();
            let target: Vec<(Joint, f64)> = axes
                .split(' ')
                .map(|word| {
                    assert!(matches!(word.as_bytes()[1], b'+' | b'-'), "a sign in {word}");
                    (Joint::parse(&word[..1]).unwrap(), word[1..].parse().unwrap())
                })
                .collect();
            let seconds = way(&at, &known, &target) / feed.parse::<f64>().unwrap() * 60.0;
            go(&mut at, &mut known, &target);
            events.push((Event::Move { to: at, seconds }, keeps));
        } else if block == "STOP" {
            events.push((Event::Stop(String::new()), keeps));
        } else if let "FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS" | "FUNCTION RESET TCPM" = block {
            keeps = block != "FUNCTION RESET TCPM";
        } else {
            assert!(block.starts_with("; ") || ["M127", "M129", "M30"].contains(&block), "{line}");
        }
    }
    events
}

/// Length of the way in mm and degrees together; axes whose place is unknown do not count.
fn way(at: &AxisValues<f64>, known: &AxisValues<bool>, target: &[(Joint, f64)]) -> f64 {
    target
        .iter()
        .filter(|(letter, _)| known[*letter])
        .map(|(letter, v)| v - at[*letter])
        .fold(0.0, f64::hypot)
}

fn go(at: &mut AxisValues<f64>, known: &mut AxisValues<bool>, target: &[(Joint, f64)]) {
    for &(letter, value) in target {
        (at[letter], known[letter]) = (value, true);
    }
}
