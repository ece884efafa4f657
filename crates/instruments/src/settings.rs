//! Unknowns that come with every mounting of an instrument: where it really sits, its zero, its own geometry.

use nalgebra::Vector3;
use trunnion_core::{InstrumentKind, Setup, Twist};
use trunnion_machine::Site;

/// One unknown of a mounting.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name, unique in the setup, e.g. `x` or `dead-path`.
    pub name: &'static str,
    /// What it is.
    pub quantity: Quantity,
    /// Where it acts.
    pub site: Site,
    /// What one unit (1 mm, 1 rad) of it does there.
    pub twist: Twist,
}

/// What a setting is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A length, mm inside.
    Length,
    /// An angle, rad inside.
    Angle,
}

/// Place of the table side, table axes.
pub(crate) fn place() -> Vec<Setting> {
    let at = |(k, name)| Setting {
        name,
        quantity: Quantity::Length,
        site: Site::TableBall,
        twist: Twist::translation(Vector3::ith(k, 1.0)),
    };
    ["x", "y", "z"].into_iter().enumerate().map(at).collect()
}

/// Place and turn of an artefact about its origin, table axes.
pub(crate) fn placement() -> Vec<Setting> {
    let about = |(k, name)| Setting {
        name,
        quantity: Quantity::Angle,
        site: Site::TableBall,
        twist: Twist::rotation(Vector3::ith(k, 1.0)),
    };
    place().into_iter().chain(["a", "b", "c"].into_iter().enumerate().map(about)).collect()
}

/// An offset of the reading: `sign` mm of reading for each mm of it.
pub(crate) fn offset(name: &'static str, sign: f64) -> Setting {
    let twist = Twist::translation(Vector3::x() * sign);
    Setting { name, quantity: Quantity::Length, site: Site::Reading, twist }
}

/// Inner unknown `k` of the instrument.
pub(crate) fn inner(k: usize, name: &'static str, quantity: Quantity) -> Setting {
    Setting { name, quantity, site: Site::Instrument(k), twist: Twist::translation(Vector3::x()) }
}

/// Ball, nest or stylus off the line of a spindle that is a joint, tool axes with the spindle at zero: it goes round with the
/// spindle, which separates it from the place of the spindle [S1 §3.2]. A reflector has its place on the tool already.
pub fn off_spindle(kind: InstrumentKind) -> Vec<Setting> {
    let clamped =
        matches!(kind, InstrumentKind::RTest | InstrumentKind::BallBar | InstrumentKind::TouchProbe);
    let across = |(k, name)| Setting {
        name,
        quantity: Quantity::Length,
        site: Site::SpindleBall,
        twist: Twist::translation(Vector3::ith(k, 1.0)),
    };
    let names = ["spindle-x", "spindle-y"];
    names.into_iter().enumerate().filter(|_| clamped).map(across).collect()
}

/// `others` and, unless it is calibrated, `zero`.
pub(crate) fn known(setup: &Setup, mut others: Vec<Setting>, zero: Setting) -> Vec<Setting> {
    if !setup.calibrated {
        others.push(zero);
    }
    others
}
