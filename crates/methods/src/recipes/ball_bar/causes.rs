//! Likely mechanical causes: a classification by the kind of error, its waves a turn, its share and its significance.
//!
//! Causes are those of S4 tables 1 and 2, bearings sorted by waves a turn: an oval ring makes two, a ring clamped in three jaws three, rollers
//! of unlike size more; teeth and rollers by the counts of the machine file. Of what is not significant nothing is said.

use super::track::Axis;
use crate::common::harmonics::{Harmonic, Harmonics};
use crate::common::significance::is_significant;
use trunnion_machine::Machine;

/// Kinds of errors that the ball bar shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorKind {
    /// Mean tilt of an axis line: E_A0, E_B0, E_C0.
    Squareness,
    /// Mean place of an axis line.
    Place,
    /// Error motion across the axis.
    Radial,
    /// Error motion along the axis.
    Axial,
    /// Change of the tilt over the turn.
    Tilt,
    /// Difference between the directions of turning.
    Reversal,
}

/// An error motion of this kind with these waves a turn, and what makes it.
struct Class {
    kind: ErrorKind,
    waves: std::ops::RangeInclusive<usize>,
    words: &'static str,
}

const CLASSES: [Class; 8] = [
    Class {
        kind: ErrorKind::Radial,
        waves: 2..=2,
        words: "an oval ring or seat of a bearing (S4 table 2: profile of rings)",
    },
    Class {
        kind: ErrorKind::Radial,
        waves: 3..=3,
        words: "a three-lobed ring or seat of a bearing, as three jaws leave it (S4 table 2: profile of rings)",
    },
    Class {
        kind: ErrorKind::Radial,
        waves: 4..=usize::MAX,
        words: "rollers of unlike size, or a ring drawn by its screws (S4 table 2)",
    },
    Class {
        kind: ErrorKind::Axial,
        waves: 1..=1,
        words: "a ring face that is not square to the axis (S4 table 2: run-out)",
    },
    Class {
        kind: ErrorKind::Axial,
        waves: 2..=2,
        words: "a ring face warped like a saddle (S4 table 2: profile of rings)",
    },
    Class {
        kind: ErrorKind::Axial,
        waves: 3..=usize::MAX,
        words: "the faces of the rings, or rollers of unlike size (S4 table 2)",
    },
    Class {
        kind: ErrorKind::Tilt,
        waves: 1..=1,
        words: "coning: one bearing runs out against the other (S4 table 2: angular motion of the centre line)",
    },
    Class {
        kind: ErrorKind::Tilt,
        waves: 2..=usize::MAX,
        words: "ring profiles of two bearings that differ (S4 table 2: angular motion of the centre line)",
    },
];

/// Gravity makes one and two waves a turn where the axis is not upright.
const GRAVITY: &str = ", or gravity on the rotating unit (S4 table 2)";
/// Rings and gravity make the lowest orders.
const FEW_WAVES: usize = 3;
/// Waves a turn that gravity makes.
const GRAVITY_WAVES: usize = 2;
/// Causes with less of the squared amplitudes are not named: below that the second is hidden in the shape of the first.
const LEAST_SHARE: f64 = 0.1;

/// The wave of a gear: every tooth pushes the axis once.
const TEETH: &str = "the teeth of its worm wheel or last gear (S4 table 2: pitch of the transmission)";
const ROLLERS: &str = "rollers of unlike size: about half of them pass a place in a turn (S4 table 2)";
/// Share f of the rollers that pass a place of a ring in a turn. A roller of diameter d on a circle D touches the inner ring, which turns at ω, at
/// (D − d)/2 and the outer one, which stands, at (D + d)/2. Without slip its middle has the mean of both speeds, ω (D − d)/4, so the cage turns
/// at ω (1 − d/D)/2. f = ½ (1 ∓ d/D) is then − at the outer ring, + at the inner one; a contact angle α makes d cos α of d [Harris 1966]. The
/// range is d/D ≤ 0.3.
const PASSING: std::ops::RangeInclusive<f64> = 0.35..=0.65;

/// What the machine file counts on an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub teeth: Option<usize>,
    pub rollers: Option<usize>,
}

impl Counts {
    pub fn of(machine: &Machine, axis: Axis) -> Self {
        let whole = |count: Option<f64>| count.map(|count| count.round() as usize);
        let facts = machine.axis(axis.letter).map(|joint| &joint.facts);
        Self {
            teeth: whole(facts.and_then(|facts| facts.gear_teeth)),
            rollers: whole(facts.and_then(|facts| facts.bearing_rollers)),
        }
    }

    /// Waves a turn that are looked for beyond the lowest.
    pub fn orders(self) -> Vec<usize> {
        self.teeth.into_iter().collect()
    }

    fn cause(self, waves: usize) -> Option<&'static str> {
        let passing = |rollers: usize| PASSING.contains(&(waves as f64 / rollers as f64));
        match self.teeth {
            Some(teeth) if teeth == waves => Some(TEETH),
            _ => (waves > FEW_WAVES && self.rollers.is_some_and(passing)).then_some(ROLLERS),
        }
    }
}

/// A likely cause of a wave, with its share of the squared amplitudes of its error motion.
pub(super) struct Cause {
    pub harmonic: Harmonic,
    pub share: f64,
    pub words: String,
}

/// Likely causes of an error motion by its significant harmonics, largest share first; none where none is significant.
pub(super) fn causes(kind: ErrorKind, upright: bool, counts: Counts, harmonics: &Harmonics) -> Vec<Cause> {
    let significant = harmonics.significant();
    let all: f64 = significant.iter().map(|harmonic| harmonic.amplitude.powi(2)).sum();
    let named = significant.into_iter().filter_map(|harmonic| {
        let share = harmonic.amplitude.powi(2) / all;
        let class = CLASSES.iter().find(|c| c.kind == kind && c.waves.contains(&harmonic.order))?;
        let gravity = if !upright && harmonic.order <= GRAVITY_WAVES { GRAVITY } else { "" };
        let words = format!("{}{gravity}", counts.cause(harmonic.order).unwrap_or(class.words));
        (share >= LEAST_SHARE).then_some(Cause { harmonic, share, words })
    });
    named.collect()
}

/// The same in a sentence; empty where none is significant.
pub(super) fn of_motion(kind: ErrorKind, upright: bool, counts: Counts, harmonics: &Harmonics) -> String {
    let one = |cause: &Cause| {
        format!("{} waves a turn, {:.0} % of it: {}", cause.harmonic.order, 100.0 * cause.share, cause.words)
    };
    let named: Vec<String> = causes(kind, upright, counts, harmonics).iter().map(one).collect();
    if named.is_empty() { String::new() } else { format!("likely: {}", named.join("; ")) }
}

/// Likely cause of a number with its standard uncertainty, one of so many quantities that are judged together; empty where it is not significant.
pub(super) fn of_number(kind: ErrorKind, value: f64, u: f64, quantities: usize) -> &'static str {
    if !is_significant(value, u, quantities) {
        return "";
    }
    match kind {
        ErrorKind::Squareness => {
            "likely: assembly, the axis is not square or parallel to its neighbour (S4 table 1)"
        }
        ErrorKind::Place => {
            "likely: assembly or an old zero offset, the axis line is not where the controller has it (S4 table 1)"
        }
        ErrorKind::Reversal => {
            "likely: backlash or friction in bearings or drive, seen as a step with the direction (S4 §4.3)"
        }
        ErrorKind::Radial | ErrorKind::Axial | ErrorKind::Tilt => "",
    }
}
