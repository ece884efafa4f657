//! What an effect may know of a setup: instrument, nest, ball, what its mounting leaves unknown.

use crate::Unit;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trunnion_core::Twist;
use trunnion_machine::{Side, Site};

/// What an effect may know of a setup.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetup {
    /// Name, e.g. `low`.
    pub name: String,
    /// Names of the components of a reading: x y z, or r.
    pub components: &'static [&'static str],
    /// Which side carries the nest; the ball is on the other.
    pub nest: Side,
    /// Nominal centre of the table-side ball or nest in table axes, mm.
    pub ball_in_table_mm: Point3<f64>,
    /// Number of the run it belongs to: each run has its own clock.
    pub run: usize,
    /// Unknowns of the mounting.
    pub settings: Vec<SceneSetting>,
    /// What is measured at several places.
    pub artefact: Option<SceneArtefact>,
}

/// An unknown that comes with a mounting: place, zero, inner geometry of the instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetting {
    /// Name, unique in the setup.
    pub name: &'static str,
    /// Unit on screens.
    pub unit: Unit,
    /// Where it acts.
    pub site: Site,
    /// What one unit (1 mm, 1 rad) of it does there.
    pub twist: Twist,
    /// Standard uncertainty beforehand, inside units, of what no reading shows to first order.
    pub u_beforehand: Option<f64>,
}

/// What an effect may know of an artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneArtefact {
    /// Name; setups with the same one measure the same thing.
    pub name: String,
    /// Names of its targets; `State::target` indexes them.
    pub targets: Vec<String>,
    /// Table axes from artefact axes.
    pub table_from_artefact: UnitQuaternion<f64>,
}

impl SceneSetup {
    /// An R-test with the nest on the table and its place as unknowns, in run 0.
    pub fn r_test(name: &str, ball_in_table_mm: Point3<f64>) -> Self {
        Self {
            name: name.into(),
            components: &["x", "y", "z"],
            nest: Side::Table,
            ball_in_table_mm,
            run: 0,
            settings: place(),
            artefact: None,
        }
    }

    /// The same on a plate of two targets, for examples.
    #[must_use]
    pub fn with_plate(self) -> Self {
        let artefact = SceneArtefact {
            name: "plate".into(),
            targets: vec!["1".into(), "2".into()],
            table_from_artefact: UnitQuaternion::identity(),
        };
        Self { artefact: Some(artefact), ..self }
    }

    /// A ball bar, likewise.
    pub fn ball_bar(name: &str, ball_in_table_mm: Point3<f64>) -> Self {
        let length = SceneSetting {
            name: "length",
            unit: Unit::UM,
            site: Site::Reading,
            twist: Twist::translation(-Vector3::x()),
            u_beforehand: None,
        };
        let settings = place().into_iter().chain([length]).collect();
        Self { components: &["r"], settings, ..Self::r_test(name, ball_in_table_mm) }
    }
}

/// Place of the table-side ball, table axes.
fn place() -> Vec<SceneSetting> {
    let along = |(k, name)| SceneSetting {
        name,
        unit: Unit::UM,
        site: Site::TableBall,
        twist: Twist::translation(Vector3::ith(k, 1.0)),
        u_beforehand: None,
    };
    ["x", "y", "z"].into_iter().enumerate().map(along).collect()
}
