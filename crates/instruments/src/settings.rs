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
    /// Standard uncertainty beforehand, inside units, of what no reading shows to first order.
    pub u_beforehand: Option<f64>,
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
        u_beforehand: None,
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
        u_beforehand: None,
    };
    place().into_iter().chain(["a", "b", "c"].into_iter().enumerate().map(about)).collect()
}

/// An offset of the reading: `sign` mm of reading for each mm of it.
pub(crate) fn offset(name: &'static str, sign: f64) -> Setting {
    let twist = Twist::translation(Vector3::x() * sign);
    Setting { name, quantity: Quantity::Length, site: Site::Reading, twist, u_beforehand: None }
}

/// Inner unknown `k` of the instrument.
pub(crate) fn inner(k: usize, name: &'static str, quantity: Quantity) -> Setting {
    let twist = Twist::translation(Vector3::x());
    Setting { name, quantity, site: Site::Instrument(k), twist, u_beforehand: None }
}

/// Inner unknown `k`: a tilt of a laser beam, which acts in second order.
///
/// A beam is aligned by eye: the returned dot moves by S = 2 D θ over the travel D, for example 0.5 mm over 500 mm [HP 5528A, distance
/// measurements, cosine error]. So θ lies anywhere within ± 0.5 mrad, with the standard uncertainty of [GUM 4.3.7].
pub(crate) fn beam(k: usize, name: &'static str) -> Setting {
    const WITHIN_RAD: f64 = 0.5 / (2.0 * 500.0);
    let u_beforehand = Some(WITHIN_RAD / 3.0_f64.sqrt());
    Setting { u_beforehand, ..inner(k, name, Quantity::Angle) }
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
        u_beforehand: None,
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
