//! Circles among the targets of a setup, about Z of the artefact, and how round they are.

use crate::common::{Mounted, Recognised};
use crate::geometry::{circle, minimum_zone};
use nalgebra::{DMatrix, DVector, Vector2};
use trunnion_core::{InstrumentKind, Point, Target};

/// Targets farther than this share of the radius from their circle are on no circle: files hold places to some µm.
const ON_CIRCLE: f64 = 1e-3;
/// Targets nearer in height are on one circle, mm.
const ONE_HEIGHT_MM: f64 = 1e-3;
/// Three waves a turn with four points each.
const LEAST_TARGETS: usize = 12;
/// Cosine between normal and radius below which the surface is rather a face than a wall.
const WALL: f64 = 0.5;

/// The circles of each setup.
pub(super) type Traces = Recognised<Vec<Round>>;

/// One circle, mm.
pub(super) struct Round {
    pub name: String,
    /// RONt, MZCI.
    pub minimum_zone_mm: f64,
    /// RONt, LSCI.
    pub least_squares_mm: f64,
    pub radius_off_mm: f64,
    /// Of the least-squares circle, X and Y of the artefact.
    pub centre_mm: [f64; 2],
    /// Angle and deviation from the least-squares circle.
    pub left: Vec<(f64, f64)>,
}

/// The circles of a setup.
///
/// # Errors
/// Why there is none.
pub(super) fn circles(mounted: &Mounted<'_>) -> Result<Vec<Round>, String> {
    let setup = mounted.setup;
    let kind = setup.instrument;
    if !matches!(kind, InstrumentKind::MachinedSurface | InstrumentKind::TouchProbeFace) {
        return Err(format!("read by {}, not along the normal of a surface", kind.with_article()));
    }
    let mut heights: Vec<(f64, Vec<(&Target, &Point)>)> = Vec::new();
    for &point in &mounted.points {
        let target = setup.artefact.as_ref().and_then(|artefact| artefact.targets.get(point.state.target));
        let target = target.ok_or("has readings of no target")?;
        let height_mm = target.at_mm.z;
        let known = heights.iter_mut().find(|(height, _)| (height - height_mm).abs() < ONE_HEIGHT_MM);
        match known {
            Some((_, readings)) => readings.push((target, point)),
            None => heights.push((height_mm, vec![(target, point)])),
        }
    }
    let several = heights.len() > 1;
    let of_height = |(height_mm, readings): &(f64, Vec<(&Target, &Point)>)| {
        let name =
            if several { format!("{} at Z{height_mm:.1}", mounted.name) } else { mounted.name.clone() };
        Round::of(name, readings)
    };
    heights.iter().map(of_height).collect()
}

impl Round {
    fn of(name: String, readings: &[(&Target, &Point)]) -> Result<Self, String> {
        if readings.len() < LEAST_TARGETS {
            return Err(format!(
                "has {} readings on a circle; {LEAST_TARGETS} or more show roundness",
                readings.len()
            ));
        }
        let places: Vec<Vector2<f64>> = readings.iter().map(|(target, _)| target.at_mm.xy()).collect();
        let no_circle = "has targets that lie on no circle about Z of the artefact";
        let nominal = circle(&places).map_err(|_| no_circle)?;
        if nominal.deviation_mm.iter().any(|off| off.abs() > ON_CIRCLE * nominal.radius_mm) {
            return Err(no_circle.into());
        }
        let mut radial = Vec::new();
        for ((target, point), place) in readings.iter().zip(&places) {
            let arm = (place - nominal.centre_mm).normalize();
            let cosine = target.normal.ok_or("has targets without a normal")?.xy().dot(&arm);
            if cosine.abs() < WALL {
                return Err("has normals along the axis of the circle: it is a face, not a wall".into());
            }
            radial.push((arm.y.atan2(arm.x), point.reading_mm[0] / cosine));
        }
        Self::fitted(name, &radial).ok_or_else(|| "has targets at fewer than four angles".into())
    }

    fn fitted(name: String, radial: &[(f64, f64)]) -> Option<Self> {
        let design = DMatrix::from_fn(radial.len(), 3, |i, j| [1.0, radial[i].0.cos(), radial[i].0.sin()][j]);
        let off_mm = DVector::from_fn(radial.len(), |i, _| radial[i].1);
        let found = design.clone().svd(true, true).solve(&off_mm, f64::EPSILON).ok()?;
        let left_mm = off_mm - design * &found;
        Some(Self {
            name,
            minimum_zone_mm: minimum_zone(radial).ok()?,
            least_squares_mm: left_mm.max() - left_mm.min(),
            radius_off_mm: found[0],
            centre_mm: [found[1], found[2]],
            left: radial.iter().map(|(angle, _)| *angle).zip(left_mm.iter().copied()).collect(),
        })
    }
}
