//! Positions of axes on the move that were rounded.
//!
//! Axes pass every place between two steps. From row to row a path is smooth: second differences Δ² leave of nominal readings n the rounding
//! of their positions, and of readings y their noise; both are √6 of what one reading has [1² + 2² + 1²]. An axis that was at its
//! positions shows the share s = Δ²n·Δ²y/Δ²n·Δ²n = 1 of it; one whose positions were rounded afterwards 0.

use super::{FINEST_UM, PART_OF_NOISE, Rounded, What};
use crate::Nominal;
use crate::plausibility::digits::Digits;
use crate::plausibility::readings::FEWEST_POINTS;
use crate::problem::stream::nominal;
use std::collections::HashMap;
use trunnion_core::convert::{deg_from_rad, rad_from_deg, um_from_mm};
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, median, rms};
use trunnion_core::{AxisValues, Joint, Point, Setup, State};
use trunnion_cycles::RunKind;
use trunnion_machine::Machine;

/// Shares nearer to 0 than to 1 by so many standard deviations are none.
const SURE: f64 = 3.0;
/// Second differences of independent errors have the correlations −2/3 and 1/6 with the next ones: 1 + 2 (4/9 + 1/36).
const CORRELATED: f64 = 1.944;
/// Errors of steps that an axis takes more slowly than rows come are up to √2 of q/√12 from row to row; twice as much is no rounding.
const MOST_OF_POSSIBLE: f64 = 2.0;
/// Readings farther off than this are no noise.
const SIGMAS: f64 = 5.0;
/// Rows beyond these say the same again.
const MOST_ROWS: usize = 20_000;
/// Every so many rows it is asked what a step makes of the reading.
const ASKED_EVERY: usize = 200;

/// Positions of a run on the fly on their way: they are looked at as they were read, before any mean is taken.
pub struct PositionDigits {
    kind: RunKind,
    nominal: Nominal,
    joints: Vec<Joint>,
    /// Of each setup.
    channels: Vec<usize>,
    digits: AxisValues<Digits>,
    moved: AxisValues<usize>,
    /// Of each setup: the last two rows.
    last: HashMap<usize, Vec<Row>>,
    /// Second differences of nominal readings and readings, mm.
    differences: Vec<[f64; 2]>,
    asked: Vec<State>,
    rows: usize,
}

struct Row {
    position: AxisValues<f64>,
    nominal_mm: [f64; 3],
    reading_mm: [f64; 3],
}

impl PositionDigits {
    /// Of a run of this machine; nothing is asked of a run at rest.
    pub fn new(machine: &Machine, setups: &[Setup], kind: RunKind) -> Self {
        Self {
            kind,
            nominal: nominal(machine, setups),
            joints: machine.joints(),
            channels: setups.iter().map(|setup| setup.instrument.components().len()).collect(),
            digits: AxisValues::default(),
            moved: AxisValues::default(),
            last: HashMap::new(),
            differences: Vec::new(),
            asked: Vec::new(),
            rows: 0,
        }
    }

    /// The next point of the run.
    pub fn take(&mut self, point: &Point) {
        if self.kind != RunKind::OnTheFly || !point.is_good() || self.is_fine() {
            return;
        }
        for &joint in &self.joints {
            let position = point.state.position[joint];
            self.digits[joint].take(if joint.is_rotary() { deg_from_rad(position) } else { position });
        }
        if self.rows >= MOST_ROWS {
            return;
        }
        let position = point.state.position;
        let nominal_mm = (self.nominal)(&point.state);
        let last = self.last.entry(point.state.setup).or_default();
        if let Some(before) = last.last() {
            let moved: Vec<Joint> =
                self.joints.iter().copied().filter(|&j| before.position[j] != position[j]).collect();
            // Of an axis that is slower than its steps the first row of each.
            if moved.is_empty() {
                return;
            }
            moved.into_iter().for_each(|joint| self.moved[joint] += 1);
        }
        if let [first, second] = &last[..] {
            let bent = |of: fn(&Row) -> [f64; 3], now: [f64; 3], k: usize| {
                of(first)[k] - 2.0 * of(second)[k] + now[k]
            };
            let of = |k: usize| {
                [bent(|row| row.nominal_mm, nominal_mm, k), bent(|row| row.reading_mm, point.reading_mm, k)]
            };
            let channels = self.channels.get(point.state.setup).copied().unwrap_or(0);
            self.differences.extend((0..channels).map(of));
            last.remove(0);
        }
        last.push(Row { position, nominal_mm, reading_mm: point.reading_mm });
        if self.rows.is_multiple_of(ASKED_EVERY) {
            self.asked.push(point.state.clone());
        }
        self.rows += 1;
    }

    /// Every axis that moves has more digits than a rounding leaves: nothing to look for.
    fn is_fine(&self) -> bool {
        self.joints.iter().all(|&joint| self.digits[joint].step().is_none())
    }

    /// What the rounding of positions hides; `None` where none is, where the readings show it, or where it is too little.
    pub fn finish(self, run: &str) -> Option<Rounded> {
        let steps: Vec<(Joint, f64)> = self
            .joints
            .iter()
            .filter(|joint| self.moved[**joint] >= FEWEST_POINTS)
            .filter_map(|&joint| Some((joint, self.digits[joint].step()?)))
            .collect();
        let (share, u, hidden_mm, noise_mm) = self.share()?;
        // An axis whose steps would show more than there is was read at exact places, as a trigger of its own encoder does.
        let steps: Vec<(Joint, f64)> = steps
            .into_iter()
            .filter(|step| self.possible_mm(&[*step]).is_some_and(|mm| mm < MOST_OF_POSSIBLE * hidden_mm))
            .collect();
        let hidden_um = um_from_mm(hidden_mm);
        let is_hidden =
            share.abs() + SURE * u < 0.5 && hidden_mm < MOST_OF_POSSIBLE * self.possible_mm(&steps)?;
        let counts = hidden_um > FINEST_UM && hidden_mm > PART_OF_NOISE * noise_mm;
        (is_hidden && counts).then(|| Rounded {
            run: run.into(),
            given: format!("in steps of {}", words(&steps)),
            hidden_um,
            what: What::Positions,
        })
    }

    /// Share with its standard deviation; the rounding and the noise of one reading, mm.
    fn share(&self) -> Option<(f64, f64, f64, f64)> {
        let sizes: Vec<f64> = self.differences.iter().map(|[_, reading]| reading.abs()).collect();
        let farthest = SIGMAS * median(&sizes)? / MEDIAN_OF_NORMAL;
        let used: Vec<[f64; 2]> =
            self.differences.iter().copied().filter(|[_, reading]| reading.abs() <= farthest).collect();
        if used.len() < FEWEST_POINTS {
            return None;
        }
        let (squares, along) =
            used.iter().fold((0.0, 0.0), |(squares, along), [n, y]| (squares + n * n, along + n * y));
        let share = along / squares;
        let left = rms(used.iter().map(|[n, y]| y - share * n))?;
        let one = 6f64.sqrt();
        let u = left * (CORRELATED / squares).sqrt();
        share.is_finite().then(|| (share, u, (squares / used.len() as f64).sqrt() / one, left / one))
    }

    /// What these steps can make of a reading, mm rms.
    fn possible_mm(&self, steps: &[(Joint, f64)]) -> Option<f64> {
        let of_state = |state: &State| {
            let before = (self.nominal)(state);
            let of_step = |&(joint, step): &(Joint, f64)| {
                let mut moved = state.clone();
                moved.position[joint] += if joint.is_rotary() { rad_from_deg(step) } else { step };
                let after = (self.nominal)(&moved);
                (0..3).map(|k| (after[k] - before[k]).powi(2)).sum::<f64>()
            };
            (steps.iter().map(of_step).sum::<f64>() / 12.0).sqrt()
        };
        rms(self.asked.iter().map(of_state))
    }
}

/// `0.01 mm (X, Y) and 0.01° (C)`.
fn words(steps: &[(Joint, f64)]) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for (joint, step) in steps {
        let size = if joint.is_rotary() { format!("{step}°") } else { format!("{step} mm") };
        match groups.iter_mut().find(|(of, _)| *of == size) {
            Some((_, joints)) => joints.push(joint.to_string()),
            None => groups.push((size, vec![joint.to_string()])),
        }
    }
    let each: Vec<String> =
        groups.iter().map(|(size, joints)| format!("{size} ({})", joints.join(", "))).collect();
    each.join("; ")
}
