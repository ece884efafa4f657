//! Geometric elements against references in 60-digit arithmetic.

use super::document::{data, digits, fewest, numbers};
use nalgebra::{SVector, Vector2, Vector3};
use serde_json::Value;
use trunnion_methods::geometry::{circle, line, plane, sphere};

/// Digits on one element.
pub struct Row {
    pub element: String,
    /// Centre or point.
    pub position: f64,
    /// Radius, or components of the direction or normal.
    pub form: f64,
}

pub fn rows() -> Vec<Row> {
    let sets = data("geometric_elements.json");
    let sets = sets.as_object().expect("named sets");
    sets.iter().map(|(name, set)| row(name, set)).collect()
}

fn points<const N: usize>(set: &Value) -> Vec<SVector<f64, N>> {
    let rows = set["points"].as_array().expect("points");
    rows.iter().map(|row| SVector::from_vec(numbers(row))).collect()
}

fn row(name: &str, set: &Value) -> Row {
    let flat = set["points"][0].as_array().expect("a point").len() == 2;
    let certified = |key: &str| numbers(&set[key]);
    let radius = || numbers(&Value::Array(vec![set["radius"].clone()]))[0];
    let (position, form) = match set["kind"].as_str().expect("a kind") {
        "circle" => {
            let found = circle(&points::<2>(set)).expect("a circle");
            (fewest(found.centre_mm.as_slice(), &certified("centre")), digits(found.radius_mm, radius()))
        }
        "sphere" => {
            let found = sphere(&points::<3>(set)).expect("a sphere");
            (fewest(found.centre_mm.as_slice(), &certified("centre")), digits(found.radius_mm, radius()))
        }
        "plane" => {
            let found = plane(&points::<3>(set)).expect("a plane");
            let normal = Vector3::from_vec(certified("normal"));
            (fewest(found.through_mm.as_slice(), &certified("through")), of_unit(found.normal, normal))
        }
        "line" if flat => {
            let found = line(&points::<2>(set)).expect("a line");
            let along = Vector2::from_vec(certified("direction"));
            (fewest(found.through_mm.as_slice(), &certified("through")), of_unit(found.direction, along))
        }
        _ => {
            let found = line(&points::<3>(set)).expect("a line");
            let along = Vector3::from_vec(certified("direction"));
            (fewest(found.through_mm.as_slice(), &certified("through")), of_unit(found.direction, along))
        }
    };
    Row { element: name.into(), position, form }
}

/// Digits of the angle between unit vectors.
fn of_unit<const N: usize>(found: SVector<f64, N>, certified: SVector<f64, N>) -> f64 {
    digits((found - certified).norm(), 0.0)
}
