//! Six errors of the tilting axis at each of its angles, all angles of the turning axis together [S1 eq. 10–15].

use super::grid::{Cell, Grid};
use crate::recipes::{Method, MethodError};
use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_core::Twist;
use trunnion_engine::solve::linear::least_squares;

/// Directions weaker than this share of the strongest are not seen.
const SEEN: f64 = 1e-7;

/// Errors of the tilting axis.
pub(super) struct BErrors {
    /// At each tilt, in the axes of what carries the axis.
    pub at_tilt: Vec<Twist>,
    /// Standard uncertainties by the residual of each fit.
    pub u_at_tilt: Vec<Twist>,
    /// Offset of each nest position, table axes, mm.
    pub offsets_mm: Vec<Vector3<f64>>,
    /// `residual[tilt]`: what each cell of [`Grid::at_tilt`] has left, table axes, mm.
    pub residual_mm: Vec<Vec<Vector3<f64>>>,
}

impl BErrors {
    pub fn of(method: &Method, grid: &Grid<'_>) -> Result<Self, MethodError> {
        let nests = grid.nests.len();
        let first = grid.tilt_near(0.0);
        // The offsets first: what they and the errors share (along and about the turning axis) is then theirs.
        let (x, u) = solve(grid, first, |s, _| Offset::Unknown(s));
        let offsets_mm: Vec<Vector3<f64>> =
            (0..nests).map(|s| x.fixed_rows::<3>(3 * s).into_owned()).collect();
        let mut errors = Self {
            at_tilt: Vec::new(),
            u_at_tilt: Vec::new(),
            residual_mm: Vec::new(),
            offsets_mm: offsets_mm.clone(),
        };
        for tilt in 0..grid.tilts_rad.len() {
            let (twist, u_twist) = if tilt == first {
                (twist_of(&x, 3 * nests), twist_of(&u, 3 * nests))
            } else {
                let (x, u) = solve(grid, tilt, |s, _| Offset::Known(offsets_mm[s]));
                (twist_of(&x, 0), twist_of(&u, 0))
            };
            let left =
                grid.at_tilt(tilt).map(|(_, s, cell)| cell.mean_mm - offsets_mm[s] - cell.of_tilting(&twist));
            errors.residual_mm.push(left.collect());
            errors.at_tilt.push(twist);
            errors.u_at_tilt.push(u_twist);
        }
        let numbers =
            errors.at_tilt.iter().flat_map(|t| t.translation_mm.iter().chain(t.rotation_rad.iter()));
        if numbers.clone().any(|number| !number.is_finite()) {
            return Err(method.lacks("a reading is no number", "Mark it in the recording or remove it."));
        }
        Ok(errors)
    }

    /// The map without what an offset of the zero pose along and about the turning axis adds to it.
    #[must_use]
    pub fn without_datum(mut self, datum: &[Twist]) -> Self {
        for (twist, datum) in self.at_tilt.iter_mut().zip(datum) {
            *twist += *datum * -1.0;
        }
        self
    }
}

/// What is known of the offset of a nest position.
enum Offset {
    Unknown(usize),
    Known(Vector3<f64>),
}

/// Unknowns at one tilt: the unknown offsets, then δ and ω.
fn solve(
    grid: &Grid<'_>,
    tilt: usize,
    offset: impl Fn(usize, &Cell) -> Offset,
) -> (DVector<f64>, DVector<f64>) {
    let cells: Vec<_> = grid.at_tilt(tilt).collect();
    let offsets: Vec<Offset> = cells.iter().map(|(_, s, cell)| offset(*s, cell)).collect();
    let unknown =
        if offsets.iter().any(|o| matches!(o, Offset::Unknown(_))) { 3 * grid.nests.len() } else { 0 };
    let mut a = DMatrix::zeros(3 * cells.len(), unknown + 6);
    let mut b = DVector::zeros(3 * cells.len());
    for (n, ((_, _, cell), offset)) in cells.iter().zip(&offsets).enumerate() {
        let known = match offset {
            Offset::Known(known) => *known,
            Offset::Unknown(s) => {
                a.fixed_view_mut::<3, 3>(3 * n, 3 * s).fill_with_identity();
                Vector3::zeros()
            }
        };
        b.fixed_rows_mut::<3>(3 * n).copy_from(&(cell.mean_mm - known));
        let [translations, rotations] = cell.columns(&cell.tilting);
        a.fixed_view_mut::<3, 3>(3 * n, unknown).copy_from(&translations);
        a.fixed_view_mut::<3, 3>(3 * n, unknown + 3).copy_from(&rotations);
    }
    let fit = least_squares(&a, &b, SEEN);
    (fit.x, fit.u)
}

fn twist_of(x: &DVector<f64>, from: usize) -> Twist {
    Twist {
        translation_mm: x.fixed_rows::<3>(from).into_owned(),
        rotation_rad: x.fixed_rows::<3>(from + 3).into_owned(),
    }
}
