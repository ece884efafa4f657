//! Cycles worth considering next, made from the machine and from what has been measured so far.
//!
//! One cycle for each thing that separates effects [docs/design/physics.md §9.18;
//! docs/design/statistics.md §4.4]: both directions, finer and offset steps, another height and radius, interleaved heights, wait and repeat, and on
//! the fly both directions at one, two and three feeds, tilted, twice round.

use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};
use trunnion_core::{AxisValues, InstrumentKind, Joint, Setup, State, convert};
use trunnion_cycles::Cycle;
use trunnion_cycles::Pace;
use trunnion_cycles::cycle::{Bar, BarFrame, GridAxis, Motion, Rounds, Settle};
use trunnion_machine::{Axis, Machine};

/// Farthest tilt asked for, rad.
const FARTHEST_TILT: f64 = 0.5 * PI;
/// Room to speed up before a sweep and to slow down after it, rad.
const RUN_UP: f64 = PI / 12.0;
/// Distance of the second height and of the second radius, mm.
const APART_MM: f64 = 100.0;

/// When a point of a planned cycle may be read.
pub(super) const SETTLE: Settle = Settle {
    window_s: 0.5,
    drift_mm: 0.5e-3,
    noise_mm: 2e-3,
    standstill_mm: 2e-3,
    standstill_rad: convert::rad_from_deg(0.001),
    timeout_s: 10.0,
};

/// A cycle and what it is good for.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub cycle: Cycle,
    pub what: String,
}

/// Everything worth considering; what the machine cannot do is left out by whoever computes the visits.
pub(super) fn candidates(
    machine: &Machine,
    setups: &[Setup],
    states: &[State],
    pace: &Pace,
) -> Vec<Candidate> {
    // No sweep turns a spindle.
    let mut rotary = machine.rotary();
    rotary.retain(|axis| machine.spindle != Some(axis.letter));
    let (Some(first), Some(turning)) = (setups.first(), rotary.last()) else { return Vec::new() };
    let tilting = rotary[..rotary.len() - 1].last().copied();
    let shop = Shop { machine, pace, tilting, turning, states };
    let low = vec![first.clone()];
    let two_heights = vec![first.clone(), moved(first, "higher", Vector3::z() * APART_MM)];
    let two_radii = vec![first.clone(), moved(first, "nearer", nearer(first, turning))];
    let mut all = shop.at_rest(&low, &two_heights, &two_radii);
    all.extend(shop.turning(&low, &two_heights, &two_radii));
    all.extend(shop.tilting(&low));
    if first.instrument == InstrumentKind::BallBar {
        all = all.into_iter().flat_map(in_all_directions).collect();
    }
    all
}

/// A ball bar sees along itself only.
fn in_all_directions(candidate: Candidate) -> Vec<Candidate> {
    [("x", Vector3::x_axis()), ("y", Vector3::y_axis()), ("z", Vector3::z_axis())]
        .into_iter()
        .map(|(name, direction)| {
            let mut cycle = candidate.cycle.clone();
            cycle.name = format!("{}-bar-{name}", cycle.name);
            cycle.bar = Bar { direction, frame: BarFrame::Machine };
            cycle.setups.iter_mut().for_each(|setup| setup.direction = None);
            Candidate { cycle, what: format!("{}, bar along {}", candidate.what, name.to_uppercase()) }
        })
        .collect()
}

fn moved(setup: &Setup, how: &str, by_mm: Vector3<f64>) -> Setup {
    Setup {
        name: format!("{}-{how}", setup.name),
        ball_in_table_mm: setup.ball_in_table_mm + by_mm,
        ..setup.clone()
    }
}

/// Towards the line of the turning axis, or away from it when the ball is near already.
fn nearer(setup: &Setup, turning: &Axis) -> Vector3<f64> {
    let from_line = setup.ball_in_table_mm - turning.through_mm;
    let along = turning.direction.into_inner();
    let radial = from_line - along * along.dot(&from_line);
    match radial.norm() {
        r if r > APART_MM => -radial * (0.6 * APART_MM / r),
        r if r > 1.0 => radial * (APART_MM / r),
        _ => Vector3::x() * APART_MM,
    }
}

struct Shop<'a> {
    machine: &'a Machine,
    pace: &'a Pace,
    /// The axis nearest the bed, if there are two.
    tilting: Option<&'a Axis>,
    turning: &'a Axis,
    states: &'a [State],
}

impl Shop<'_> {
    fn at_rest(&self, low: &[Setup], two_heights: &[Setup], two_radii: &[Setup]) -> Vec<Candidate> {
        let t = self.turning.letter;
        let once = Rounds::default();
        let c = |from: f64, step: f64| self.turn_stations(from, step);
        let mut all = vec![self.grid(
            "stations",
            format!("{t} every 15°, both directions, at rest"),
            low,
            vec![c(0.0, 15.0)],
            once,
        )];
        let Some(tilting) = self.tilting else { return all };
        let b = |shift: f64, step: f64| tilt_stations(tilting, shift, step);
        let l = tilting.letter;
        let mut add = |name: &str, what: String, setups: &[Setup], grid: [GridAxis; 2], rounds: Rounds| {
            all.push(self.grid(name, what, setups, grid.into(), rounds));
        };
        let coarse = || [b(0.0, 45.0), c(0.0, 60.0)];
        add(
            "grid",
            format!("{l} and {t} every 30°, both directions"),
            low,
            [b(0.0, 30.0), c(0.0, 30.0)],
            once,
        );
        add(
            "grid-two-heights",
            format!("{l} and {t} every 30°, both directions, two heights"),
            two_heights,
            [b(0.0, 30.0), c(0.0, 30.0)],
            once,
        );
        add("fine-turn", format!("{t} every 7.5°, {l} every 45°"), low, [b(0.0, 45.0), c(0.0, 7.5)], once);
        add("fine-tilt", format!("{l} every 10°, {t} every 90°"), low, [b(0.0, 10.0), c(0.0, 90.0)], once);
        add(
            "offset",
            format!("{l} every 30° from 15°, {t} every 25° from 11°"),
            low,
            [b(15.0, 30.0), c(11.0, 25.0)],
            once,
        );
        add("two-heights", "a second height, coarse grid".into(), two_heights, coarse(), once);
        add("two-radii", "a second ball radius, coarse grid".into(), two_radii, coarse(), once);
        add(
            "interleaved",
            "two heights in turn, all mounted".into(),
            two_heights,
            coarse(),
            Rounds { count: 2, interleave: true, ..once },
        );
        add(
            "wait-and-repeat",
            "a coarse grid three times with 10 minutes in between".into(),
            low,
            coarse(),
            Rounds { count: 3, wait_s: 600.0, ..once },
        );
        all
    }

    fn turning(&self, low: &[Setup], two_heights: &[Setup], two_radii: &[Setup]) -> Vec<Candidate> {
        let t = self.turning;
        let l = t.letter;
        let [one, two, three] = self.feeds(t);
        let fly = |name: &str, what: String, setups: &[Setup], feeds: &[f64], span: (f64, f64), tilt: f64| {
            let mut others = AxisValues::default();
            if let Some(axis) = self.tilting {
                others[axis.letter] = tilt;
            }
            self.sweep(name, what, setups, t, feeds, span, others)
        };
        let round = whole_turn(t);
        let mut all = vec![
            fly("turn", format!("{l} turns both ways at one feed"), low, &one, round, 0.0),
            fly("turn-two-feeds", format!("{l} turns both ways at two feeds"), low, &two, round, 0.0),
            fly("turn-three-feeds", format!("{l} turns both ways at three feeds"), low, &three, round, 0.0),
            fly(
                "turn-two-heights",
                format!("{l} turns both ways at two feeds, two heights"),
                two_heights,
                &two,
                round,
                0.0,
            ),
            fly(
                "turn-two-radii",
                format!("{l} turns both ways at two feeds, two radii"),
                two_radii,
                &two,
                round,
                0.0,
            ),
            fly(
                "turn-slowly",
                format!("{l} turns both ways slowly: every tooth of its drive"),
                low,
                &[one[0] / 4.0],
                round,
                0.0,
            ),
        ];
        if t.travel.1 - RUN_UP >= round.0 + 2.0 * TAU {
            let twice = (round.0, round.0 + 2.0 * TAU);
            all.push(fly(
                "turn-twice",
                format!("{l} turns twice both ways at two feeds"),
                low,
                &two,
                twice,
                0.0,
            ));
        }
        if let Some(axis) = self.tilting {
            let tilt = (0.25 * PI).min(0.8 * axis.travel.1.max(-axis.travel.0));
            let tilt = if axis.travel.1 >= tilt { tilt } else { -tilt };
            let what = format!(
                "{l} turns both ways at two feeds, {} at {:.0}°",
                axis.letter,
                convert::deg_from_rad(tilt)
            );
            all.push(fly("turn-tilted", what, low, &two, round, tilt));
        }
        all
    }

    fn tilting(&self, low: &[Setup]) -> Vec<Candidate> {
        let Some(axis) = self.tilting else { return Vec::new() };
        let [one, two, _] = self.feeds(axis);
        let (low_end, high_end) = with_room(axis);
        let span = (low_end.max(-FARTHEST_TILT), high_end.min(FARTHEST_TILT));
        let l = axis.letter;
        let fly = |name: &str, what: String, feeds: &[f64], turn: f64| {
            let mut others = AxisValues::default();
            others[self.turning.letter] = turn;
            self.sweep(name, what, low, axis, feeds, span, others)
        };
        vec![
            fly("tilt", format!("{l} tilts both ways at one feed"), &one, 0.0),
            fly("tilt-two-feeds", format!("{l} tilts both ways at two feeds"), &two, 0.0),
            fly(
                "tilt-crosswise",
                format!("{l} tilts both ways at two feeds, {} at 90°", self.turning.letter),
                &two,
                0.5 * PI,
            ),
        ]
    }

    fn grid(
        &self,
        name: &str,
        what: String,
        setups: &[Setup],
        grid: Vec<GridAxis>,
        rounds: Rounds,
    ) -> Candidate {
        let motion = Motion::Static { grid, passes: vec![1.0, -1.0], settle: SETTLE };
        self.candidate(name, what, setups, motion, rounds)
    }

    #[expect(clippy::too_many_arguments, reason = "a cycle has that many facts")]
    fn sweep(
        &self,
        name: &str,
        what: String,
        setups: &[Setup],
        axis: &Axis,
        feeds: &[f64],
        from_to_rad: (f64, f64),
        others: AxisValues<f64>,
    ) -> Candidate {
        let motion = Motion::OnTheFly {
            axis: axis.letter,
            from_to_rad,
            feeds_rad_per_s: feeds.into(),
            passes: vec![1.0, -1.0],
            others: AxisValues::from_fn(|letter| (others[letter], others[letter])),
        };
        self.candidate(name, what, setups, motion, Rounds::default())
    }

    fn candidate(
        &self,
        name: &str,
        what: String,
        setups: &[Setup],
        motion: Motion,
        rounds: Rounds,
    ) -> Candidate {
        let cycle = Cycle {
            name: name.into(),
            machine: self.machine.name.clone(),
            setups: setups.into(),
            motion,
            rounds,
            bar: Bar::default(),
        };
        Candidate { cycle, what }
    }

    /// One, two and three feeds: the one used so far, and others a factor of two away.
    fn feeds(&self, axis: &Axis) -> [Vec<f64>; 3] {
        let limit = axis.facts.feed_limit.unwrap_or(self.pace.rotary_rad_per_s);
        let speeds = self.states.iter().map(|state| state.velocity[axis.letter].abs());
        let used = speeds.filter(|speed| *speed > 1e-6).fold(f64::INFINITY, f64::min);
        let base = if used.is_finite() { used.min(limit) } else { 0.25 * limit };
        // A feed that a person would type; velocities in recordings have noise.
        let base = convert::rad_from_deg((convert::deg_from_rad(base) * 60.0).round().max(1.0)) / 60.0;
        let two = if 2.0 * base <= 0.5 * limit { [base, 2.0 * base] } else { [0.5 * base, base] };
        [vec![base], two.into(), vec![0.5 * two[0], two[0], two[1]]]
    }

    fn turn_stations(&self, from_deg: f64, step_deg: f64) -> GridAxis {
        let (low, high) = whole_turn(self.turning);
        let (from, step) = (low + convert::rad_from_deg(from_deg), convert::rad_from_deg(step_deg));
        let end = high.min(low + TAU - 0.5 * step);
        stations(self.turning.letter, from, end, step)
    }
}

fn tilt_stations(axis: &Axis, shift_deg: f64, step_deg: f64) -> GridAxis {
    let step = convert::rad_from_deg(step_deg);
    let (low, high) = (axis.travel.0.max(-FARTHEST_TILT), axis.travel.1.min(FARTHEST_TILT));
    // Stations of whole steps from zero, so that the zero position is one of them.
    let from = (low / step - 1e-6).ceil() * step + convert::rad_from_deg(shift_deg);
    stations(axis.letter, from, high, step)
}

fn stations(letter: Joint, from: f64, to: f64, step: f64) -> GridAxis {
    let count = ((to - from) / step + 1e-6).floor().max(0.0) as usize;
    GridAxis { letter, stations: (0..=count).map(|i| from + step * i as f64).collect() }
}

/// 0…360°, or as much as the axis can do with room to speed up and slow down.
fn whole_turn(axis: &Axis) -> (f64, f64) {
    let (low, high) = with_room(axis);
    let from = 0f64.min(high - TAU).max(low);
    (from, (from + TAU).min(high))
}

fn with_room(axis: &Axis) -> (f64, f64) {
    (axis.travel.0 + RUN_UP, axis.travel.1 - RUN_UP)
}
