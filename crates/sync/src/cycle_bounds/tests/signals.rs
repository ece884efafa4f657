//! A signal that is on or off, a number, or a counter.

use super::*;

/// A controller that reports a signal; with an execution other than unknown, of the program `P`.
fn with(time_s: f64, execution: Execution, number: impl Into<Option<u32>>) -> Reading {
    match reported(time_s, execution, if execution == Unknown { "" } else { "P" }, "") {
        Reading::Controller(controller) => {
            Reading::Controller(ControllerReading { signal: number.into(), ..controller })
        }
        other => other,
    }
}

fn signal(time_s: f64, number: impl Into<Option<u32>>) -> Reading {
    with(time_s, Unknown, number)
}

#[test]
fn a_signal_begins_it_when_it_comes_on_and_ends_it_when_it_goes_off() {
    let story = [signal(1.0, 0), signal(2.0, 1), signal(3.0, None), signal(4.0, 1), signal(5.0, 0)];
    assert_eq!(bounds(StartRule::Signal, &story), [2.0, -5.0]);
    let by_number = |story: &[Reading]| {
        let mut bounds = CycleBounds::new(StartRule::Signal).by_number(true);
        let number = |now: &Reading| match bounds.take(now)? {
            Bound::Begins { signal, why, .. } => {
                assert!(why.ends_with(&format!("the signal is {}", signal.unwrap_or_default())), "{why}");
                signal
            }
            Bound::Ends { .. } => Some(0),
        };
        story.iter().filter_map(number).collect::<Vec<u32>>()
    };
    assert_eq!(by_number(&[signal(1.0, 0), signal(2.0, 7), signal(3.0, 0)]), [7, 0]);
    // One number after the other, with nothing between.
    assert_eq!(by_number(&[signal(1.0, 0), signal(2.0, 2), signal(3.0, 7)]), [2, 7]);
    // The end of the program and of its signal in one reading.
    let story = [
        with(1.0, Ready, 0),
        with(2.0, Active, 3),
        with(3.0, Ready, 0),
        with(4.0, Active, 4),
        with(5.0, Ready, 0),
    ];
    assert_eq!(by_number(&story), [3, 0, 4, 0]);
    // The end of one program and the number of the next in one reading.
    let story = [
        with(1.0, Ready, 0),
        with(2.0, Active, 3),
        with(3.0, Ready, 4),
        with(4.0, Active, 4),
        with(5.0, Ready, 4),
        with(6.0, Active, 4),
    ];
    assert_eq!(by_number(&story), [3, 4, 0]);
    // A number that is not known for a while is the same afterwards, or another.
    let story = [Some(0), Some(2), None, Some(2), None, Some(7), None, Some(0)];
    let story: Vec<Reading> = (0..8).map(|k| signal(f64::from(k), story[k as usize])).collect();
    assert_eq!(by_number(&story), [2, 7, 0]);
}

#[test]
fn a_signal_that_counts_is_on_until_it_is_0_where_no_number_is_asked_for() {
    let story: Vec<Reading> =
        (0..).zip([0, 1, 2, 3, 0]).map(|(k, number)| signal(f64::from(k), number)).collect();
    assert_eq!(bounds(StartRule::Signal, &story), [1.0, -4.0]);
    let ended = [with(1.0, Ready, 0), with(2.0, Active, 1), with(3.0, Ready, 2), with(4.0, Active, 2)];
    assert_eq!(bounds(StartRule::Signal, &ended), [2.0, -3.0]);
}

#[test]
fn a_cycle_that_a_person_began_is_not_ended_by_a_signal_that_was_never_on() {
    let mut bounds = CycleBounds::new(StartRule::Signal);
    assert_eq!(bounds.take(&signal(1.0, 0)), None);
    bounds.begun_otherwise();
    assert_eq!(bounds.take(&signal(2.0, 0)), None, "it never was on");
    assert_eq!(bounds.take(&signal(3.0, 1)), None, "of the cycle that runs");
    assert!(matches!(bounds.take(&signal(4.0, 0)), Some(Bound::Ends { .. })));
}
