//! Circle, line, plane and sphere fits against published results, and where they refuse.

use nalgebra::{Rotation3, Vector2, Vector3};
use proptest::prelude::*;
use trunnion_methods::geometry::{GeometryError, circle, line, plane, sphere};

#[test]
fn the_circle_of_gander_golub_and_strebel_is_met() {
    let points = [(1.0, 7.0), (2.0, 6.0), (5.0, 8.0), (7.0, 7.0), (9.0, 5.0), (3.0, 7.0)];
    let found = circle(&points.map(|(x, y)| Vector2::new(x, y))).expect("six points");
    assert!((found.centre_mm - Vector2::new(4.739782, 2.983533)).amax() < 5.1e-7, "{found:?}");
    assert!((found.radius_mm - 4.714226).abs() < 5.1e-7, "{found:?}");
}

/// Pearson 1901, his ten points: tan θ = −0.5456, through (0, 5.784) (figures to four digits as he prints them).
#[test]
fn the_line_of_pearson_is_met() {
    let points = [
        (0.0, 5.9),
        (0.9, 5.4),
        (1.8, 4.4),
        (2.6, 4.6),
        (3.3, 3.5),
        (4.4, 3.7),
        (5.2, 2.8),
        (6.1, 2.8),
        (6.5, 2.4),
        (7.4, 1.5),
    ];
    let found = line(&points.map(|(x, y)| Vector2::new(x, y))).expect("ten points");
    let slope = found.direction.y / found.direction.x;
    let at_zero = found.through_mm.y - slope * found.through_mm.x;
    assert!((slope + 0.5456).abs() < 5e-5 && (at_zero - 5.784).abs() < 5e-4, "{slope} {at_zero}");
}

#[test]
fn points_that_decide_nothing_are_refused() {
    let on_a_line: Vec<Vector3<f64>> = (0..5).map(|i| Vector3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
    for refused in [plane(&on_a_line).err(), sphere(&on_a_line).err()] {
        assert!(matches!(refused, Some(GeometryError::Undetermined { .. })), "{refused:?}");
    }
    let same = [Vector2::new(0.1, 0.2); 4];
    assert!(matches!(line(&same), Err(GeometryError::Undetermined { .. })));
    assert!(matches!(circle(&same[..2]), Err(GeometryError::TooFew { least: 3, found: 2, .. })));
    let bad = [Vector2::new(0.0, 1.0), Vector2::new(f64::NAN, 0.0), Vector2::new(1.0, 1.0)];
    let shown = circle(&bad).expect_err("no number").to_string();
    assert!(shown.contains("point 1 of the circle"), "{shown}");
}

#[test]
fn a_short_arc_far_away_keeps_its_digits() {
    let (centre, radius) = (Vector2::new(1234.5, -987.25), 50.0);
    let arc: Vec<_> = (0..9)
        .map(|i| (f64::from(i) * 5.0).to_radians())
        .map(|a| centre + Vector2::new(a.cos(), a.sin()) * radius)
        .collect();
    let found = circle(&arc).expect("an arc of 40°");
    assert!((found.centre_mm - centre).norm() < 1e-9 && (found.radius_mm - radius).abs() < 1e-9, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    /// Moving, turning and reordering the points moves and turns the shapes: nothing else changes.
    #[test]
    fn shapes_move_with_their_points(
        noise in prop::collection::vec(-0.5..0.5f64, 60),
        turn in prop::array::uniform3(-3.0..3.0f64),
        shift in prop::array::uniform3(-500.0..500.0f64),
    ) {
        let turn = Rotation3::new(Vector3::from(turn));
        let shift = Vector3::from(shift);
        let ball: Vec<Vector3<f64>> = (0..20)
            .map(|i| {
                let (t, p) = (0.3 + 0.12 * f64::from(i), 2.4 * f64::from(i));
                let k = 3 * i as usize;
                Vector3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()) * 20.0
                    + Vector3::new(noise[k], noise[k + 1], noise[k + 2])
            })
            .collect();
        let moved: Vec<_> = ball.iter().rev().map(|p| turn * p + shift).collect();
        let (here, there) = (sphere(&ball).unwrap(), sphere(&moved).unwrap());
        prop_assert!((turn * here.centre_mm + shift - there.centre_mm).norm() < 1e-9);
        prop_assert!((here.radius_mm - there.radius_mm).abs() < 1e-9);
        // Least: no neighbouring sphere is nearer to the points.
        for step in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let squares = |c: Vector3<f64>| -> f64 {
                ball.iter().map(|p| ((p - c).norm() - here.radius_mm).powi(2)).sum()
            };
            prop_assert!(squares(here.centre_mm) <= squares(here.centre_mm + step * 1e-4));
        }

        let flat: Vec<_> = ball.iter().map(|p| Vector3::new(p.x * 4.0, p.y * 2.0, p.z * 0.05)).collect();
        let moved: Vec<_> = flat.iter().map(|p| turn * p + shift).collect();
        let (here, there) = (plane(&flat).unwrap(), plane(&moved).unwrap());
        prop_assert!((turn * here.normal).cross(&there.normal).norm() < 1e-9);
        prop_assert!((here.rms_mm - there.rms_mm).abs() < 1e-10);
        let (here, there) = (line(&flat).unwrap(), line(&moved).unwrap());
        prop_assert!((turn * here.direction).cross(&there.direction).norm() < 1e-9);
        prop_assert!((here.rms_mm - there.rms_mm).abs() < 1e-10);
    }
}
