mod signals;

use super::*;
use crate::StaticRules;
use trunnion_core::input::Document;
use trunnion_core::reading::AxisReading;
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::cycle::{Motion, Pose};

fn at(time_s: f64) -> HostTime {
    HostTime((time_s * 1e9) as i64)
}

/// A controller as last reported.
fn reported(time_s: f64, execution: Execution, program: &str, block: &str) -> Reading {
    Reading::Controller(ControllerReading {
        execution,
        program: program.into(),
        block: block.into(),
        signal: None,
        stamp_ns: 0,
        arrival: at(time_s),
    })
}

fn axes(time_s: f64, c_rad: f64) -> Reading {
    let mut position = AxisValues::default();
    position[Joint::C] = c_rad;
    Reading::Axes(AxisReading {
        stamp_ns: 0,
        arrival: at(time_s),
        position,
        present: AxisValues::from_fn(|_| true),
        sequence: 0,
        held: false,
        skew_ns: 0,
    })
}

/// Begins (+) and ends (−) with their times, s.
fn bounds(rule: StartRule, readings: &[Reading]) -> Vec<f64> {
    let mut bounds = CycleBounds::new(rule);
    let signed = |bound| match bound {
        Bound::Begins { at, .. } => at.0 as f64 / 1e9,
        Bound::Ends { at, .. } => -at.0 as f64 / 1e9,
    };
    readings.iter().filter_map(|reading| bounds.take(reading)).map(signed).collect()
}

use Execution::{Active, Ended, Held, Ready, Stopped, Unknown};

#[test]
fn a_program_begins_and_ends_the_cycle_and_a_hold_or_a_lost_link_does_not() {
    let story = [
        reported(0.0, Ready, "", ""),
        reported(1.0, Active, "P", "N1"),
        reported(2.0, Held, "P", "N1"),
        reported(3.0, Active, "P", "N2"),
        reported(4.0, Unknown, "", ""),
        reported(5.0, Active, "P", "N3"),
        reported(6.0, Ended, "P", ""),
        reported(7.0, Ready, "P", ""),
        reported(8.0, Active, "P", ""),
    ];
    assert_eq!(bounds(StartRule::Execution, &story), [1.0, -6.0, 8.0]);
}

#[test]
fn a_program_that_goes_on_after_the_last_pose_is_not_the_next_cycle() {
    let mut bounds = CycleBounds::new(StartRule::Execution);
    assert!(bounds.take(&reported(1.0, Active, "P", "N1")).is_some());
    bounds.ended_otherwise();
    assert_eq!(bounds.take(&reported(2.0, Active, "P", "N99")), None);
    assert_eq!(bounds.take(&reported(3.0, Ended, "P", "")), None);
    assert!(matches!(bounds.take(&reported(4.0, Active, "P", "N1")), Some(Bound::Begins { .. })));
}

#[test]
fn only_the_named_program_begins_it() {
    let rule = || StartRule::Program(Pattern::new("*trunnion*"));
    let story = [
        reported(1.0, Active, "WARM_UP", ""),
        reported(2.0, Ended, "WARM_UP", ""),
        reported(3.0, Active, "/_N_MPF_DIR/_N_TRUNNION_MPF", ""),
        // The actual program is a subprogram.
        reported(4.0, Active, "L100", ""),
        reported(5.0, Ready, "L100", ""),
    ];
    assert_eq!(bounds(rule(), &story), [3.0, -5.0]);
    // Without an execution state the name alone decides.
    let silent = [
        reported(1.0, Unknown, "", ""),
        reported(2.0, Unknown, "trunnion1", ""),
        reported(3.0, Unknown, "main", ""),
    ];
    assert_eq!(bounds(rule(), &silent), [2.0, -3.0]);
}

#[test]
fn blocks_begin_and_end_it() {
    let rule = StartRule::Block { begin: Pattern::new("*begin*"), end: Some(Pattern::new("*end*")) };
    let story = [
        reported(1.0, Active, "P", "N1 G1"),
        reported(2.0, Active, "P", "MSG(\"CYCLE BEGIN\")"),
        reported(3.0, Active, "P", "N2 G1"),
        reported(4.0, Active, "P", "MSG(\"CYCLE END\")"),
        reported(5.0, Active, "P", "N3"),
        reported(6.0, Active, "P", "MSG(\"CYCLE BEGIN\")"),
        reported(7.0, Ended, "P", ""),
    ];
    assert_eq!(bounds(rule, &story), [2.0, -4.0, 6.0, -7.0]);
}

/// Stands and motions one after the other at 50 Hz; C goes 1 rad in 0.4 s.
fn moving(stands_s: &[f64]) -> Vec<Reading> {
    let (mut readings, mut time_s, mut c_rad) = (Vec::new(), 0.0, 0.0);
    for stand_s in stands_s {
        for _ in 0..(stand_s * 50.0) as usize {
            readings.push(axes(time_s, c_rad));
            time_s += 0.02;
        }
        for _ in 0..20 {
            c_rad += 0.05;
            readings.push(axes(time_s, c_rad));
            time_s += 0.02;
        }
    }
    readings
}

#[test]
fn motion_after_a_rest_begins_it_and_a_long_stand_ends_it() {
    let rule = StartRule::Motion { rest_s: 2.0, still_s: 5.0 };
    let found = bounds(rule, &moving(&[1.0, 3.0, 2.5, 4.0, 7.0, 1.0]));
    // 1.0 + 0.4 + 3.0; the last motion before the long stand ends at 1.0 + 3.0 + 2.5 + 4.0 + 4·0.4.
    let expected = [4.4, -(12.1 + 5.0 - 0.02), 19.1];
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.1), "{found:?}");
}

#[test]
fn stands_of_the_given_lengths_begin_it_and_others_do_not() {
    let rule = || StartRule::Dwells { dwells_s: vec![2.0, 1.0, 2.0], still_s: 30.0 };
    assert_eq!(bounds(rule(), &moving(&[2.0, 2.0, 1.0, 1.0, 2.0])), [0.0; 0]);
    // 2.0 twice: the second is the first of the pattern.
    let found = bounds(rule(), &moving(&[0.7, 2.0, 2.0, 1.0, 2.0, 3.0]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0] - (0.7 + 2.0 + 2.0 + 1.0 + 2.0 + 4.0 * 0.4)).abs() < 0.1, "{found:?}");
}

#[test]
fn patterns_match_whole_names() {
    let check = |pattern: &str, text: &str, expected: bool| {
        assert_eq!(Pattern::new(pattern).matches(text), expected, "{pattern} {text}");
    };
    check("r-test", "R-TEST", true);
    check("r-test", "r-test.ngc", false);
    check("r-test*", "r-test.ngc", true);
    check("*r*t*.ngc", "/home/r-test.ngc", true);
    check("*a*b*", "ba", false);
    check("aa*aa", "aaa", false);
    check("*", "", true);
}

#[test]
fn the_table_is_read_and_its_mistakes_are_reported() {
    let read = |text: &str| {
        let document = Document::parse("t.toml", text).unwrap();
        let root = document.root();
        let rule = StartRule::read(&root);
        drop(root);
        document.finish(rule).map_err(|problems| problems.to_string())
    };
    assert_eq!(read(""), Ok(StartRule::Execution));
    let motion = "[cycle_start]\nby = \"motion\"\nstill_s = 20\n";
    assert_eq!(read(motion), Ok(StartRule::Motion { rest_s: 2.0, still_s: 20.0 }));
    let expect = |text: &str, piece: &str| {
        let shown = read(text).unwrap_err();
        assert!(shown.contains(piece), "{piece:?} not in:\n{shown}");
    };
    expect("[cycle_start]\nby = \"magic\"\n", "execution, program, block, signal, dwells, motion");
    expect("[cycle_start]\nby = \"program\"\n", "program is missing in [cycle_start]");
    expect("[cycle_start]\nby = \"dwells\"\ndwells_s = [0.1]\n", "0.5..=60");
    expect("[cycle_start]\nby = \"signal\"\nstill_s = 3\n", "still_s");
}

/// What the vocabularies promise, said again without a state machine: the last state that is no hold decides.
fn promised(story: &[Option<Execution>]) -> Vec<i64> {
    let (mut running, mut last, mut bounds) = (false, Ready, Vec::new());
    for (k, now) in story.iter().enumerate() {
        let at = k as i64 + 1;
        match now {
            None => running = false,
            Some(Active) => {
                let again = matches!(last, Ready | Ended) || last == Stopped && !running;
                if again {
                    bounds.push(at);
                    running = true;
                }
                last = Active;
            }
            Some(over @ (Ready | Ended)) => {
                if running {
                    bounds.push(-at);
                }
                (running, last) = (false, *over);
            }
            Some(Stopped) => last = Stopped,
            Some(Held | Unknown) => {}
        }
    }
    bounds
}

#[test]
fn in_any_order_of_states_every_program_begins_once_and_no_hold_cuts_it() {
    // `None`: all poses are read, or a person ends the cycle.
    let alphabet = [Some(Ready), Some(Active), Some(Held), Some(Stopped), Some(Ended), Some(Unknown), None];
    let steps: u32 = 6;
    for number in 0..alphabet.len().pow(steps) {
        let digit = |k: u32| alphabet[number / alphabet.len().pow(k) % alphabet.len()];
        let story: Vec<Option<Execution>> = (0..steps).map(digit).collect();
        let mut bounds = CycleBounds::new(StartRule::Execution);
        let mut found = Vec::new();
        for (k, now) in story.iter().enumerate() {
            let at = k as i64 + 1;
            let bound = match now {
                None => {
                    bounds.ended_otherwise();
                    None
                }
                Some(now) => bounds.take(&reported(at as f64, *now, "P", "")),
            };
            found.extend(bound.map(|bound| if matches!(bound, Bound::Begins { .. }) { at } else { -at }));
        }
        assert_eq!(found, promised(&story), "{story:?}");
    }
}

#[test]
fn after_an_unasked_stop_the_block_shows_whether_the_program_goes_on() {
    let story = |again: &str| {
        let run = [
            reported(1.0, Active, "P", "N10"),
            reported(2.0, Active, "P", "N500 G1"),
            reported(3.0, Stopped, "P", "N500 G1"),
            reported(3.4, Active, "P", again),
            reported(9.0, Ended, "P", ""),
        ];
        bounds(StartRule::Execution, &run)
    };
    assert_eq!(story("N510"), [1.0, -9.0]);
    assert_eq!(story("N10"), [1.0, 3.4, -9.0]);
    assert_eq!(story("G1 X1"), [1.0, -9.0]);
}

#[test]
fn a_program_that_stays_stopped_is_over_after_a_while() {
    let story = [
        reported(1.0, Active, "P", ""),
        reported(2.0, Stopped, "P", ""),
        axes(100.0, 0.0),
        axes(122.5, 0.0),
        axes(123.0, 0.0),
        reported(200.0, Active, "P", ""),
    ];
    assert_eq!(bounds(StartRule::Execution, &story), [1.0, -122.5, 200.0]);
}

#[test]
fn a_main_program_that_calls_the_cycle_twice_gives_two_cycles() {
    let rule = || StartRule::Program(Pattern::new("*cycle*"));
    let story = [
        reported(1.0, Active, "MAIN", ""),
        reported(2.0, Active, "CYCLE", ""),
        reported(3.0, Active, "L100", ""),
        reported(4.0, Active, "CYCLE", ""),
        reported(5.0, Active, "MAIN", ""),
        reported(5.4, Active, "CYCLE", ""),
        reported(8.0, Active, "MAIN", ""),
        reported(9.0, Ended, "MAIN", ""),
    ];
    assert_eq!(bounds(rule(), &story), [2.0, -5.0, 5.4, -8.0]);

    // The name does not change: the first pose shows the second call, once the machine was elsewhere.
    let text = include_str!("../../../../config/cycles/demo-static.toml");
    let cycle = trunnion_cycles::Cycle::parse("c.toml", text).unwrap();
    let Motion::Static { settle, .. } = cycle.motion else { panic!("it is static") };
    let (position, direction) = Default::default();
    let pose = Pose { setup: 0, target: 0, position, direction };
    let first = StandsAt::pose(&pose, vec![Joint::C], &StaticRules::new(settle));
    let mut bounds = CycleBounds::new(StartRule::Execution).with_first_pose(Some(first));
    assert!(bounds.take(&reported(1.0, Active, "MAIN", "")).is_some());
    assert!(moving(&[1.0, 1.0]).iter().all(|reading| bounds.take(reading).is_none()));
    bounds.ended_otherwise();
    let back: Vec<_> = [(4.0, 0.0), (4.5, 0.0), (5.0, 1.0), (6.0, 0.0), (6.1, 0.0), (6.3, 0.0), (6.5, 0.0)]
        .iter()
        .filter_map(|&(time_s, c_rad)| bounds.take(&axes(time_s, c_rad)))
        .collect();
    assert!(matches!(&back[..], [Bound::Begins { at: found, .. }] if *found == at(6.3)), "{back:?}");
}

#[test]
fn a_program_that_ran_before_anyone_asked_begins_and_says_so() {
    let mut bounds = CycleBounds::new(StartRule::Execution);
    let Some(Bound::Begins { why, under_way: true, .. }) = bounds.take(&reported(1.0, Active, "P", "N700"))
    else {
        panic!()
    };
    assert!(why.contains("first asked"), "{why}");
    let mut bounds = CycleBounds::new(StartRule::Execution);
    assert_eq!(bounds.take(&reported(1.0, Ready, "P", "")), None);
    let begins = bounds.take(&reported(2.0, Active, "P", "N10"));
    assert!(matches!(begins, Some(Bound::Begins { under_way: false, .. })), "{begins:?}");
}
