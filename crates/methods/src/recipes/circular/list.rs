//! The classical errors of a circle, each as columns over the trace (header of `circular`).

use super::sample::{Reversal, Sample};
use super::trace::Trace;
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_effects::Unit;
use trunnion_machine::Machine;

/// One error of the list.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Listed {
    pub kind: ListedKind,
    /// E.g. `backlash X`.
    pub name: String,
    pub unit: Unit,
    /// What a positive value means, or where it comes from.
    pub about: &'static str,
}

/// Which error; the number is the index of the axis in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ListedKind {
    Squareness,
    ScaleMismatch,
    ServoMismatch,
    /// The same where the speed is not known, as a distance.
    ServoDistance,
    Backlash(usize),
    LateralPlay(usize),
    ReversalSpike(usize),
    Cyclic(usize, f64),
    Straightness(usize),
}

impl ListedKind {
    /// Whether it is this cause of an axis of the plane, under one number: then nothing of the cause is missing from the list.
    pub fn is_wholly(self, phenomenon: &str, axis: Joint, plane: [Joint; 2]) -> bool {
        match self {
            Self::Backlash(k) | Self::ReversalSpike(k) => {
                self.phenomenon() == Some(phenomenon) && plane[k] == axis
            }
            _ => false,
        }
    }

    /// The phenomenon of the catalogue that it is; `None` for what the catalogue lacks.
    pub fn phenomenon(self) -> Option<&'static str> {
        match self {
            Self::Squareness => Some("squareness"),
            Self::ScaleMismatch => Some("linear-scale"),
            Self::ServoMismatch | Self::ServoDistance => Some("servo-lag"),
            Self::Backlash(_) => Some("backlash"),
            Self::LateralPlay(_) => None,
            Self::ReversalSpike(_) => Some("reversal-spike"),
            Self::Cyclic(..) => Some("ballscrew-pitch"),
            Self::Straightness(_) => Some("straightness"),
        }
    }
}

/// Every error that this trace can hold.
pub(super) fn listed(machine: &Machine, trace: &Trace) -> Vec<Listed> {
    let [a, b] = trace.plane;
    let both_ways = trace.both_ways();
    let item = |kind, name: String, unit, about| Listed { kind, name, unit, about };
    let squareness = ["EC0Y", "EA0Z", "EB0Z"][a.index()];
    let oval = if both_ways {
        let about = "squareness: oval at 45°, the same both ways";
        item(ListedKind::Squareness, squareness.into(), Unit::URAD, about)
    } else {
        // One name for what is one number, so that nobody takes it for the squareness.
        let about = "squareness, servo mismatch and a part of any backlash, which one way does not separate: oval at 45°";
        item(ListedKind::Squareness, format!("{squareness} with servo {a}−{b}"), Unit::URAD, about)
    };
    let mut list = vec![
        oval,
        item(
            ListedKind::ScaleMismatch,
            format!("scale {a}−{b}"),
            Unit::UM_PER_M,
            "scale mismatch, first axis longer: oval at 0° or 90°, the same both ways",
        ),
    ];
    if both_ways {
        let about = "servo mismatch, first axis later: oval at 45° that flips with the way";
        list.push(if trace.knows_speed() {
            item(ListedKind::ServoMismatch, format!("servo {a}−{b}"), Unit::MS, about)
        } else {
            let about = "servo mismatch times the unknown speed, first axis later: oval at 45° that flips with the way";
            item(ListedKind::ServoDistance, format!("servo {a}−{b} × speed"), Unit::UM, about)
        });
    }
    for (k, letter) in trace.plane.into_iter().enumerate() {
        let screw_lead_mm = machine.axis(letter).and_then(|axis| axis.facts.screw_lead_mm);
        if both_ways {
            let about =
                "reversal value, negative where the axis stops short (lost motion): steps where it reverses";
            list.push(item(ListedKind::Backlash(k), format!("backlash {letter}"), Unit::UM, about));
            let about = "sideways shift with the direction of the axis";
            list.push(item(ListedKind::LateralPlay(k), format!("lateral play {letter}"), Unit::UM, about));
        }
        let about = "sticks after it reverses, positive where it lags";
        list.push(item(ListedKind::ReversalSpike(k), format!("reversal spike {letter}"), Unit::UM, about));
        if let Some(lead_mm) = screw_lead_mm.filter(|lead| *lead < trace.radius_mm) {
            let about = "amplitude of one wave a screw lead";
            list.push(item(ListedKind::Cyclic(k, lead_mm), format!("cyclic {letter}"), Unit::UM, about));
        }
        let about = "bow of the guide over ±R: three lobes, the same both ways";
        list.push(item(ListedKind::Straightness(k), format!("straightness {letter}"), Unit::UM, about));
    }
    list
}

/// Sign of r = ± γ R sin φ cos φ: the later axis leans about the third direction (EC0Y, EA0Z, EB0Z).
fn squareness_sign(a: Joint) -> f64 {
    if a == Joint::Z { 1.0 } else { -1.0 }
}

/// The columns of an error at one reading, mm per inside unit of the error. `decay_mm`: s₀ of the spikes of a and b.
pub(super) fn columns(kind: ListedKind, trace: &Trace, decay_mm: [f64; 2], sample: &Sample) -> Vec<f64> {
    let (sin, cos) = sample.angle_rad.sin_cos();
    let r_mm = trace.radius_mm;
    let [along, across] = [[cos, sin], [sin, cos]];
    match kind {
        ListedKind::Squareness => vec![squareness_sign(trace.plane[0]) * r_mm * sin * cos],
        ListedKind::ScaleMismatch => vec![0.5 * r_mm * (cos * cos - sin * sin)],
        ListedKind::ServoMismatch => vec![sample.speed_mm_per_s * sample.way * sin * cos],
        ListedKind::ServoDistance => vec![sample.way * sin * cos],
        ListedKind::Backlash(k) => vec![0.5 * sample.direction[k] * along[k]],
        ListedKind::LateralPlay(k) => vec![0.5 * sample.direction[k] * across[k]],
        ListedKind::ReversalSpike(k) => {
            vec![match sample.reversal[k] {
                Reversal::Since(travel_mm) => spike(sample, k, travel_mm, decay_mm[k]),
                Reversal::Unknown { .. } => 0.0,
            }]
        }
        ListedKind::Cyclic(k, lead_mm) => {
            let (s, c) = (TAU * sample.position_mm[k] / lead_mm).sin_cos();
            vec![c * along[k], s * along[k]]
        }
        ListedKind::Straightness(k) => vec![along[k] * along[k] * across[k]],
    }
}

/// One column for each beginning at which an axis may have reversed: what sticks there, whatever its size. None of them is an error of the list.
pub(super) fn of_beginnings(trace: &Trace, decay_mm: [f64; 2], sample: &Sample) -> Vec<f64> {
    let mut columns = vec![0.0; trace.beginnings];
    for k in [0, 1] {
        if let Reversal::Unknown { beginning, travel_mm } = sample.reversal[k] {
            columns[beginning] = spike(sample, k, travel_mm, decay_mm[k]);
        }
    }
    columns
}

/// What a spike of one changes with its decay, in shares of the decay.
pub(super) fn of_decay(k: usize, decay_mm: f64, sample: &Sample) -> f64 {
    match sample.reversal[k] {
        Reversal::Since(travel_mm) => travel_mm / decay_mm * spike(sample, k, travel_mm, decay_mm),
        Reversal::Unknown { .. } => 0.0,
    }
}

/// What an axis that lags by one after its reversal adds to the reading.
fn spike(sample: &Sample, k: usize, travel_mm: f64, decay_mm: f64) -> f64 {
    let (sin, cos) = sample.angle_rad.sin_cos();
    -sample.direction[k] * (-travel_mm / decay_mm).exp() * [cos, sin][k]
}
