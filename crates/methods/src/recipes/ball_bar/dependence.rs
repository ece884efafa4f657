//! On what a wave of a trace depends: direction, feed, where the other rotary axes stand. Each rules causes in or out.
//!
//! The waves of two contours of one measurement are compared order by order [`Harmonics::differs`], at 5 % for all quantities of the answer together.
//! What changes with the direction or the feed is drive, friction or inertia and not the ring of a bearing; what changes with the tilt of the
//! axis is gravity or what carries it [S4 table 2, §4.3].
//! Limits: whole turns; what is not shown to depend may do so by less than its uncertainty.

use super::causes::ErrorKind;
use super::shape::Shape;
use super::track::Kind;
use crate::common::harmonics::{Difference, Harmonics};
use trunnion_core::Joint;
use trunnion_core::convert::deg_from_rad;
use trunnion_core::number::fixed;

/// What a wave depends on.
#[derive(Clone, Debug)]
pub(super) struct Dependence {
    pub axis: Joint,
    pub kind: ErrorKind,
    pub order: usize,
    /// Half of what changes, mm, and its standard uncertainty.
    pub half_mm: f64,
    pub u_mm: f64,
    pub words: String,
}

/// How many comparisons there are.
pub(super) fn count(shapes: &[Shape]) -> usize {
    comparisons(shapes).len()
}

/// Every dependence that the traces show, each comparison one of so many quantities that are judged together.
pub(super) fn dependences(shapes: &[Shape], quantities: usize) -> Vec<Dependence> {
    let mut found: Vec<Dependence> = Vec::new();
    let mut add = |shape: &Shape, differences: Vec<Difference>, words: &str| {
        let (Some(axis), Some(kind)) = (shape.kind.axis(), kind_of(shape.kind)) else { return };
        for Difference { order, half, u } in differences {
            let known = |other: &&mut Dependence| {
                (other.axis, other.kind, other.order) == (axis.letter, kind, order) && other.words == words
            };
            match found.iter_mut().find(known) {
                Some(other) if other.half_mm >= half => {}
                Some(other) => (other.half_mm, other.u_mm) = (half, u),
                None => found.push(Dependence {
                    axis: axis.letter,
                    kind,
                    order,
                    half_mm: half,
                    u_mm: u,
                    words: words.into(),
                }),
            }
        }
    };
    for Comparison { shape, one, two, words } in &comparisons(shapes) {
        add(shape, one.differs(two, quantities), words);
    }
    found
}

/// Two contours of one measurement between which one thing changed.
struct Comparison<'a> {
    shape: &'a Shape,
    one: Harmonics,
    two: Harmonics,
    words: String,
}

fn comparisons(shapes: &[Shape]) -> Vec<Comparison<'_>> {
    let mut all = Vec::new();
    for (i, shape) in shapes.iter().enumerate().filter(|(_, shape)| kind_of(shape.kind).is_some()) {
        if let [(_, forward), (_, backward)] = &shape.contours[..]
            && let (Some(one), Some(two)) = (waves(forward), waves(backward))
        {
            let words = "changes with the direction: drive or friction".into();
            all.push(Comparison { shape, one, two, words });
        }
        all.extend(shapes[..i].iter().filter_map(|other| compared(other, shape)));
    }
    all
}

/// One measurement in two traces between which one thing changed; `None` where nothing did, or more.
fn compared<'a>(other: &Shape, shape: &'a Shape) -> Option<Comparison<'a>> {
    if !shape.is_same_measurement(other) {
        return None;
    }
    let words = match (shape.stands_as(other), shape.turns_as_fast(other)) {
        (true, false) => "changes with the feed: servo or inertia".into(),
        (false, true) => {
            format!("changes with {}: gravity, or what carries the axis", moved(other, shape))
        }
        _ => return None,
    };
    let (one, two) = (waves(&other.mean_contour)?, waves(&shape.mean_contour)?);
    Some(Comparison { shape, one, two, words })
}

/// Of one contour, to be compared: by itself nothing of it is judged.
fn waves(contour: &[(f64, f64)]) -> Option<Harmonics> {
    Harmonics::among(contour, 1)
}

/// Whether a trace is compared with another one.
pub(super) fn is_compared(shape: &Shape, shapes: &[Shape]) -> bool {
    shapes.iter().any(|other| compared(other, shape).is_some())
}

fn kind_of(kind: Kind) -> Option<ErrorKind> {
    match kind {
        Kind::Across { .. } => Some(ErrorKind::Radial),
        Kind::Along { .. } => Some(ErrorKind::Axial),
        Kind::Followed { .. } | Kind::Path => None,
    }
}

/// `B (0° to 30°)`.
fn moved(from: &Shape, to: &Shape) -> String {
    let most = Joint::ROTARY.into_iter().max_by(|&a, &b| {
        let apart = |joint: Joint| (from.stood_rad[joint] - to.stood_rad[joint]).abs();
        apart(a).total_cmp(&apart(b))
    });
    most.map_or(String::new(), |joint| {
        let [from, to] = [from, to].map(|shape| deg_from_rad(shape.stood_rad[joint]));
        format!("{joint} ({}° to {}°)", fixed(from, 0), fixed(to, 0))
    })
}
