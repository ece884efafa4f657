//! `roundness` on shapes whose roundness is known, and the minimum zone against a search.

use proptest::prelude::*;
use std::f64::consts::TAU;
use trunnion_core::{Point, Quality};
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_machine::shipped;
use trunnion_methods::geometry::minimum_zone;
use trunnion_methods::recipes::{self, MethodError, MethodOptions};

const UM: f64 = 1e-3;

/// The machined cone with a radial deviation in µm over the angle.
fn cone(radial_um: impl Fn(f64) -> f64) -> Run {
    let path = format!("{}/../../config/cycles/machined-cone.toml", env!("CARGO_MANIFEST_DIR"));
    let cycle = Cycle::parse("cycle.toml", &std::fs::read_to_string(path).unwrap())
        .unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let half_angle = 15f64.to_radians();
    let point = |state: trunnion_core::State| {
        let target = &cycle.setups[state.setup].artefact.as_ref().unwrap().targets[state.target];
        let angle = target.name.split(' ').nth(1).unwrap().parse::<f64>().unwrap().to_radians();
        let reading_mm = [radial_um(angle) * UM * half_angle.cos(), 0.0, 0.0];
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points = cycle.visits(&machine, &Pace::default()).unwrap().states.into_iter().map(point).collect();
    Run {
        name: "cone".into(),
        machine,
        kind: RunKind::OnTheFly,
        setups: cycle.setups.clone(),
        channels: vec![],
        points,
    }
}

/// Three lobes of amplitude A lie between circles 2 A apart, wherever the part was clamped and whatever its radius.
#[test]
fn three_lobes_are_as_round_as_their_height_wherever_the_part_lies() {
    let run = cone(|angle| 2.0 * (3.0 * angle).cos() + 40.0 + 100.0 * (angle - 0.4).cos());
    let found = recipes::find("roundness").unwrap().apply(&[run], &MethodOptions::default()).unwrap();
    for circle in ["cone at Z0.0", "cone at Z29.0"] {
        for (name, expected) in [("roundness", 4.0), ("roundness, least squares", 4.0), ("radius", 40.0)] {
            let value = found.value(&format!("{name} of {circle}")).unwrap();
            assert!((value.value / UM - expected).abs() < 1e-6, "{name} {circle}: {}", value.value / UM);
        }
    }
}

#[test]
fn a_plate_of_faces_is_no_circle() {
    let mut run = cone(|_| 0.0);
    for setup in &mut run.setups {
        for target in &mut setup.artefact.as_mut().unwrap().targets {
            target.at_mm.x *= 0.5;
        }
    }
    let error = recipes::find("roundness").unwrap().apply(&[run], &MethodOptions::default()).unwrap_err();
    assert!(
        matches!(error, MethodError::Lacks { .. }) && error.to_string().contains("lie on no circle"),
        "{error}"
    );
}

/// Width of the zone about a centre.
fn width(points: &[(f64, f64)], [a, b]: [f64; 2]) -> f64 {
    let left = points.iter().map(|(angle, off)| off - a * angle.cos() - b * angle.sin());
    let (low, high) = left.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r), h.max(r)));
    high - low
}

proptest! {
    #[test]
    fn no_centre_has_a_narrower_zone(offs in prop::collection::vec(-1.0..1.0f64, 5..40), shift in 0.0..1.0f64) {
        let count = offs.len() as f64;
        let points: Vec<(f64, f64)> =
            offs.iter().enumerate().map(|(k, off)| (TAU * (k as f64 + shift) / count, *off)).collect();
        let zone = minimum_zone(&points).unwrap();
        // From a coarse grid of centres inward; the zone is a convex function of the centre.
        let (mut best, mut at, mut step) = (width(&points, [0.0; 2]), [0.0; 2], 1.0);
        while step > 1e-4 {
            let mut moved = false;
            for k in 0..24 {
                let (sin, cos) = (TAU * f64::from(k) / 24.0).sin_cos();
                let tried = [at[0] + step * cos, at[1] + step * sin];
                if width(&points, tried) < best {
                    (best, at, moved) = (width(&points, tried), tried, true);
                }
            }
            step *= if moved { 1.0 } else { 0.5 };
        }
        prop_assert!(zone <= best + 1e-9, "{zone} {best}");
        // That is also a zone: the search comes near to it.
        prop_assert!(best - zone < 0.02, "{zone} {best}");
    }
}
