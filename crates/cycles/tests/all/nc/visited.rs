//! What a program did against what its cycle expands to.

use crate::interpreter::Event;
use nalgebra::Point3;
use trunnion_core::{AxisValues, Joint, State, convert};
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_cycles::{CourseRules, Visits};
use trunnion_machine::{JointErrors, Machine};

/// A wrong digit of an angle moves the linear axes by their arm; the longest, mm.
const ARM_MM: f64 = 300.0;

/// Every pose or point of the cycle is visited in its order, positions written with this many decimals.
pub fn visited(
    events: &[Event],
    cycle: &Cycle,
    machine: &Machine,
    rules: &CourseRules,
    decimals: usize,
    named: &dyn Fn(usize) -> String,
) {
    let visits = cycle.visits(machine, &rules.pace).unwrap();
    if let Some(settle) = cycle.settle() {
        let dwell_s = rules.pace.settle_s + 2.0 * settle.window_s;
        return stands(events, &visits, dwell_s, decimals, named);
    }
    let on_piece = |state: &State, piece: &Piece| match matches!(cycle.motion, Motion::Path { .. }) {
        false => on_sweep(state, piece, decimals, rules),
        true => on_curve(state, piece, decimals, rules, machine),
    };
    passes(events, &visits, &on_piece, named);
}

/// Every pose at rest: the next dwell of its length stands there, and each axis of the grid came from the side of the pass.
fn stands(events: &[Event], visits: &Visits, dwell_s: f64, decimals: usize, named: &dyn Fn(usize) -> String) {
    let mut poses = visits.states.iter().enumerate();
    let (mut at, mut heading) = (AxisValues::<f64>::default(), AxisValues::<f64>::default());
    let mut seen = 0;
    for event in events {
        match event {
            Event::Move { to, .. } => {
                for letter in Joint::ALL {
                    if to[letter] != at[letter] {
                        heading[letter] = (to[letter] - at[letter]).signum();
                    }
                }
                at = *to;
            }
            // Waits are shorter or longer.
            Event::Dwell { seconds } if (*seconds - dwell_s).abs() < 1e-3 => {
                let (i, state) =
                    poses.next().unwrap_or_else(|| panic!("more dwells than poses: {}", named(seen)));
                for letter in Joint::ALL {
                    assert!(off(state, &at, letter) <= rounding(decimals), "{}: {letter} {at:?}", named(i));
                    // Linear axes follow the ball on the way, not the straight line from pose to pose.
                    if letter.is_rotary() && state.direction[letter] != 0.0 {
                        assert_eq!(heading[letter], state.direction[letter], "{}: {letter}", named(i));
                    }
                }
                seen += 1;
            }
            Event::Dwell { .. } | Event::Stop(_) => {}
        }
    }
    assert_eq!(seen, visits.states.len(), "{}", named(seen));
}

/// A straight piece: from, to, seconds; mm and degrees.
type Piece = (AxisValues<f64>, AxisValues<f64>, f64);

/// Every point on the fly lies on a later straight piece, near enough and at its speed.
fn passes(
    events: &[Event],
    visits: &Visits,
    on_piece: &dyn Fn(&State, &Piece) -> bool,
    named: &dyn Fn(usize) -> String,
) {
    let mut pieces = Vec::new();
    let mut at = AxisValues::<f64>::default();
    for event in events {
        if let Event::Move { to, seconds } = event {
            pieces.push((at, *to, *seconds));
            at = *to;
        }
    }
    let mut next = 0;
    for (i, state) in visits.states.iter().enumerate() {
        let found = (next..pieces.len()).find(|&k| on_piece(state, &pieces[k]));
        next = found.unwrap_or_else(|| panic!("{}: {:?} is never passed", named(i), state.position));
    }
}

/// The turning axis passes the point at its feed with the others where they belong.
fn on_sweep(state: &State, (from, to, seconds): &Piece, decimals: usize, rules: &CourseRules) -> bool {
    let Some(turning) = Joint::ROTARY.into_iter().find(|&letter| state.velocity[letter] != 0.0) else {
        return false;
    };
    let travel = to[turning] - from[turning];
    let u = (edge(state.position[turning], turning) - from[turning]) / travel;
    let speed = travel / seconds / edge(state.velocity[turning], turning);
    // The rounding of both ends of a short piece is in its speed.
    let allowed = 0.002 + 2.0 * rounding(decimals) / travel.abs();
    if !(-0.01..=1.01).contains(&u) || (speed - 1.0).abs() > allowed {
        return false;
    }
    let near = rules.chord_mm + rounding(decimals) * (1.0 + convert::rad_from_deg(ARM_MM));
    let here = AxisValues::from_fn(|letter| from[letter] + (to[letter] - from[letter]) * u);
    Joint::ALL.into_iter().all(|letter| off(state, &here, letter) <= near)
}

/// The tool passes the point of the curve over the table at its feed.
fn on_curve(
    state: &State,
    (from, to, seconds): &Piece,
    decimals: usize,
    rules: &CourseRules,
    machine: &Machine,
) -> bool {
    let none = JointErrors::default();
    let tip = |at: &AxisValues<f64>| {
        machine.machine_from_table(at, &none).inverse()
            * (machine.machine_from_tool(at, &none) * Point3::origin())
    };
    let written = |at: &AxisValues<f64>| {
        tip(&AxisValues::from_fn(|l| if l.is_rotary() { convert::rad_from_deg(at[l]) } else { at[l] }))
    };
    let (begins, ends, point) = (written(from), written(to), tip(&state.position));
    let way = ends - begins;
    let u = (point - begins).dot(&way) / way.norm_squared();
    let off_mm = (point - begins - way * u).norm();
    let dt = 1e-3;
    let soon = tip(&AxisValues::from_fn(|letter| state.position[letter] + state.velocity[letter] * dt));
    let speed = way.norm() / seconds / ((soon - point).norm() / dt);
    let rounded_mm = 4.0 * rounding(decimals) * (1.0 + convert::rad_from_deg(ARM_MM));
    (-0.01..=1.01).contains(&u)
        && off_mm <= rules.chord_mm + rounded_mm
        && (speed - 1.0).abs() < 0.005 + rounded_mm / way.norm()
        && Joint::ROTARY.into_iter().all(|letter| off(state, to, letter) < 2.0)
}

/// mm as they are, rad as degrees.
fn edge(value: f64, letter: Joint) -> f64 {
    if letter.is_rotary() { convert::deg_from_rad(value) } else { value }
}

/// Distance from the pose, mm or degrees.
fn off(state: &State, at: &AxisValues<f64>, letter: Joint) -> f64 {
    (at[letter] - edge(state.position[letter], letter)).abs()
}

fn rounding(decimals: usize) -> f64 {
    0.51 * 10f64.powi(-(decimals as i32)) + 1e-9
}
