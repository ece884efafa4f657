//! What stands on the table is met from above alone, after the stop to mount it.

use crate::interpreter::Event;
use nalgebra::Point3;
use trunnion_core::{AxisValues, InstrumentKind, Joint, convert};
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_machine::{JointErrors, Machine};

/// mm/min of the way down and up [docs/use/nc-programs.md].
const SLOW_MM_PER_MIN: f64 = 300.0;
/// Positions are rounded to three decimals at least, mm.
const ROUNDED_MM: f64 = 2e-3;

/// First up, then over the place, a stop to mount, straight down, a stop to look; at the end straight up.
pub fn keeps_clear(events: &[Event], cycle: &Cycle, machine: &Machine, rules: &CourseRules, named: &str) {
    let stops: Vec<usize> = (0..events.len()).filter(|&i| matches!(events[i], Event::Stop(_))).collect();
    let moves = |from: usize, to: usize| -> Vec<(AxisValues<f64>, f64)> {
        events[from..to]
            .iter()
            .filter_map(|event| match event {
                Event::Move { to, seconds } => Some((*to, *seconds)),
                Event::Dwell { .. } | Event::Stop(_) => None,
            })
            .collect()
    };
    let approach = moves(0, stops[0]);
    let first = approach[0].0;
    assert!(at_height(&first, 0.0) == AxisValues::default(), "{named}: first Z alone, not {first:?}");
    assert!(
        approach.iter().all(|(to, _)| to[Joint::Z] == first[Joint::Z]),
        "{named}: leaves its height before mounting"
    );
    let over = approach[approach.len() - 1].0;
    let down = moves(stops[0], stops[1]);
    straight(&over, &down, -1.0, rules, named);

    // Over all that the table carries; an upright grid plate reaches up to its highest pose.
    let none = JointErrors::default();
    let inside =
        AxisValues::from_fn(|l| if l.is_rotary() { convert::rad_from_deg(over[l]) } else { over[l] });
    let tip = (machine.machine_from_tool(&inside, &none) * cycle.setups[0].ball_in_tool_mm).z;
    let balls = cycle.setups.iter().map(|setup| setup.ball_in_table_mm);
    let height = |ball: Point3<f64>| (machine.machine_from_table(&inside, &none) * ball).z;
    let highest = balls.map(height).fold(f64::NEG_INFINITY, f64::max);
    assert!(tip > highest - ROUNDED_MM, "{named}: {tip} is lower than the ball at {highest}");
    if cycle.setups[0].instrument == InstrumentKind::CrossGrid {
        let visits = cycle.visits(machine, &rules.pace).unwrap().states;
        let top = visits.iter().map(|state| state.position[Joint::Z]).fold(f64::NEG_INFINITY, f64::max);
        assert!(
            over[Joint::Z] > top + rules.clearance_mm - ROUNDED_MM,
            "{named}: plate up to {top}, {over:?}"
        );
    }

    let all = moves(0, events.len());
    let [.., (from, _), up] = &all[..] else { panic!("{named}: too few moves") };
    straight(from, &[*up], 1.0, rules, named);
}

fn at_height(at: &AxisValues<f64>, z: f64) -> AxisValues<f64> {
    let mut there = *at;
    there[Joint::Z] = z;
    there
}

/// One way along Z, by the clearance at least, slowly.
fn straight(
    from: &AxisValues<f64>,
    moves: &[(AxisValues<f64>, f64)],
    sign: f64,
    rules: &CourseRules,
    named: &str,
) {
    let [(to, seconds)] = moves else { panic!("{named}: one way down or up, not {moves:?}") };
    let way = sign * (to[Joint::Z] - from[Joint::Z]);
    assert!(at_height(to, from[Joint::Z]) == *from, "{named}: straight, not from {from:?} to {to:?}");
    assert!(way > rules.clearance_mm - ROUNDED_MM, "{named}: {way} mm of clearance");
    assert!((way / seconds * 60.0 / SLOW_MM_PER_MIN - 1.0).abs() < 1e-6, "{named}: {way} mm in {seconds} s");
}
