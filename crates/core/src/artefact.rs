//! An artefact with several places to measure: the balls of a plate, the faces of a column or a workpiece.
//!
//! ```toml
//! [setup.artefact]
//! name = "plate-1"                       # the same thing in several setups shares its form
//! turned_deg = [90, 0, 0]                # how it stands in table axes: about X, then Y, then Z of the artefact
//! [[setup.artefact.target]]
//! name = "1-1"
//! at_mm = [0, 0, 0]                      # artefact axes, from ball_in_table_mm of the setup
//! normal = [1, 0, 0]                     # faces only: outward, artefact axes
//! ```

use crate::input::Table;
use crate::{InstrumentKind, convert};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// Something calibrated, or cut, with several places to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Artefact {
    /// Name; setups with the same one measure the same thing.
    pub name: String,
    /// How it is turned in table axes: about its X, then Y, then Z, rad.
    pub turned_rad: Vector3<f64>,
    /// Where it is measured.
    pub targets: Vec<Target>,
}

/// One place of an artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name, unique in the artefact.
    pub name: String,
    /// Nominal place from the artefact's origin, artefact axes, mm.
    pub at_mm: Vector3<f64>,
    /// Outward normal of a face, artefact axes.
    pub normal: Option<Unit<Vector3<f64>>>,
}

impl Artefact {
    /// Table axes from artefact axes.
    pub fn table_from_artefact(&self) -> UnitQuaternion<f64> {
        let about = |k: usize| UnitQuaternion::from_scaled_axis(Vector3::ith(k, self.turned_rad[k]));
        about(0) * about(1) * about(2)
    }

    /// Nominal place of a target in table axes when the artefact's origin is at `origin_in_table_mm`.
    pub fn target_in_table_mm(&self, origin_in_table_mm: &Point3<f64>, target: usize) -> Point3<f64> {
        let at_mm = self.targets.get(target).map_or_else(Vector3::zeros, |target| target.at_mm);
        origin_in_table_mm + self.table_from_artefact() * at_mm
    }

    /// Outward normal of a target in table axes.
    pub fn normal_in_table(&self, target: usize) -> Option<Unit<Vector3<f64>>> {
        Some(self.table_from_artefact() * self.targets.get(target)?.normal?)
    }
}

/// Reads the `artefact` table of a setup.
pub(crate) fn read_artefact(table: &Table<'_>, kind: Option<InstrumentKind>) -> Option<Artefact> {
    let name = table.string("name");
    let turned_deg = if table.has("turned_deg") { table.vector3("turned_deg")? } else { Vector3::zeros() };
    let tables = table.tables("target");
    if tables.is_empty() {
        table.problem("target", "has no entry", "one [[setup.artefact.target]] for each place", "");
    }
    let mut targets: Vec<Target> = Vec::new();
    for entry in &tables {
        let Some(target) = read_target(entry, kind) else { continue };
        if targets.iter().any(|other| other.name == target.name) {
            let found = format!("= \"{}\" appears twice", target.name);
            entry.problem("name", found, "a name of its own for each target", "");
        }
        targets.push(target);
    }
    table.no_other_keys();
    let complete = !targets.is_empty() && targets.len() == tables.len();
    complete.then_some(Artefact { name: name?, turned_rad: turned_deg.map(convert::rad_from_deg), targets })
}

fn read_target(table: &Table<'_>, kind: Option<InstrumentKind>) -> Option<Target> {
    let name = table.string("name");
    let at_mm = table.vector3("at_mm");
    let normal = table.optional_vector3("normal");
    if kind.is_some_and(InstrumentKind::has_normals) && normal.is_none_or(|normal| normal.norm() < 1e-6) {
        table.problem("normal", "is missing or has no length", "the outward normal, e.g. [1, 0, 0]", "");
    }
    table.no_other_keys();
    Some(Target { name: name?, at_mm: at_mm?, normal: normal.map(convert::unit) })
}
