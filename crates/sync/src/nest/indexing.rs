//! Ball off the spindle line: s(θ) = s₀ + R_z(θ)·e, a circle over spindle angles θ       [S1 §3.2]

use nalgebra::{DMatrix, DVector, Vector2, Vector3};

/// Result of [`ball_offset`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallOffset {
    /// Ball centre off the spindle line at spindle angle 0, along nest x and y, mm.
    pub offset_mm: Vector2<f64>,
    /// Reading of the spindle line itself, mm: what the offset must be taken off from.
    pub centre_mm: Vector2<f64>,
    /// Root mean square of the residual, mm: roundness of spindle and ball.
    pub residual_rms_mm: f64,
}

/// Centre shift of the ball from readings at indexed spindle angles (rad, reading in nest axes, mm); the spindle is
/// parallel to nest z and turns right-handed about it. `None` when the angles do not separate offset from centre.
pub fn ball_offset(readings: &[(f64, Vector3<f64>)]) -> Option<BallOffset> {
    let readings: Vec<_> = readings.iter().filter(|(_, s)| s.x.is_finite() && s.y.is_finite()).collect();
    let n = readings.len();
    // x = cx + ex·cosθ − ey·sinθ ; y = cy + ex·sinθ + ey·cosθ
    let design = DMatrix::from_fn(2 * n, 4, |row, column| {
        let (sin, cos) = readings[row / 2].0.sin_cos();
        [[1.0, 0.0, cos, -sin], [0.0, 1.0, sin, cos]][row % 2][column]
    });
    let observed = DVector::from_fn(2 * n, |row, _| readings[row / 2].1[row % 2]);
    if n < 2 {
        return None;
    }
    let svd = design.clone().svd(true, true);
    if svd.singular_values[3] < 0.05 * svd.singular_values[0] {
        return None;
    }
    let found = svd.solve(&observed, 0.0).ok()?;
    let residual = observed - design * &found;
    Some(BallOffset {
        offset_mm: Vector2::new(found[2], found[3]),
        centre_mm: Vector2::new(found[0], found[1]),
        residual_rms_mm: residual.norm() / ((2 * n) as f64).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indexing_the_spindle_finds_the_ball_off_its_line() {
        let (offset, centre) = (Vector2::new(0.012, -0.007), Vector2::new(0.1, 0.2));
        let at = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            let turned = Vector2::new(cos * offset.x - sin * offset.y, sin * offset.x + cos * offset.y);
            (deg.to_radians(), Vector3::new(centre.x + turned.x, centre.y + turned.y, 0.3))
        };
        let found = ball_offset(&[0.0, 90.0, 180.0, 270.0].map(at)).unwrap();
        assert!((found.offset_mm - offset).norm() < 1e-12 && (found.centre_mm - centre).norm() < 1e-12);
        assert!(found.residual_rms_mm < 1e-12);
        assert_eq!(ball_offset(&[0.0, 0.5, 1.0].map(at)), None);
    }
}
