//! Six errors of the tilting axis at each of its angles, all angles of the turning axis together [S1 eq. 10–15], and the offset of each
//! nest position, in one fit: of one tilt alone the offsets would bring its noise into all others.

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
    /// Standard uncertainties by the residual of the fit.
    pub u_at_tilt: Vec<Twist>,
    /// Offset of each nest position, table axes, mm.
    pub offsets_mm: Vec<Vector3<f64>>,
    /// `residual[tilt]`: what each cell of [`Grid::at_tilt`] has left, table axes, mm.
    pub residual_mm: Vec<Vec<Vector3<f64>>>,
    /// A: three rows for each cell, tilt by tilt; columns of the offsets, then of the errors.
    pub design: DMatrix<f64>,
    /// (AᵀA)⁻¹.
    pub cofactor: DMatrix<f64>,
    /// First column of the errors at each tilt.
    pub of_tilt: Vec<usize>,
}

impl BErrors {
    pub fn of(method: &Method, grid: &Grid<'_>) -> Result<Self, MethodError> {
        let order = Columns::of(grid);
        let (design, read) = order.design(grid);
        let fit = least_squares(&design, &read, SEEN);
        let offsets_mm: Vec<Vector3<f64>> =
            (0..grid.nests.len()).map(|s| fit.x.fixed_rows::<3>(3 * s).into_owned()).collect();
        let twists = |of: &DVector<f64>| order.of_tilt.iter().map(|from| twist_of(of, *from)).collect();
        let (at_tilt, u_at_tilt): (Vec<Twist>, Vec<Twist>) = (twists(&fit.x), twists(&fit.u));
        let left = |(tilt, twist): (usize, &Twist)| {
            let of_cell =
                |(_, s, cell): (usize, usize, &Cell)| cell.mean_mm - offsets_mm[s] - cell.of_tilting(twist);
            grid.at_tilt(tilt).map(of_cell).collect()
        };
        let residual_mm = at_tilt.iter().enumerate().map(left).collect();
        let (cofactor, of_tilt) = (fit.cofactor, order.of_tilt);
        let errors = Self { at_tilt, u_at_tilt, offsets_mm, residual_mm, design, cofactor, of_tilt };
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

/// Columns of the unknowns.
struct Columns {
    /// First column of the six errors at each tilt; before them are three for each nest position.
    of_tilt: Vec<usize>,
}

impl Columns {
    /// What offsets and errors share, along and about the turning axis, is then an offset: of columns that depend on others the last
    /// count as zero, which are those of the tilt nearest 0.
    fn of(grid: &Grid<'_>) -> Self {
        let (first, tilts) = (grid.tilt_near(0.0), grid.tilts_rad.len());
        let place = |tilt: usize| match tilt {
            tilt if tilt == first => tilts - 1,
            tilt => tilt - usize::from(tilt > first),
        };
        Self { of_tilt: (0..tilts).map(|tilt| 3 * grid.nests.len() + 6 * place(tilt)).collect() }
    }

    /// Rows of every cell, tilt by tilt, and what was read there.
    fn design(&self, grid: &Grid<'_>) -> (DMatrix<f64>, DVector<f64>) {
        let of_tilt = |tilt| grid.at_tilt(tilt).map(move |(_, s, cell)| (tilt, s, cell));
        let cells: Vec<_> = (0..grid.tilts_rad.len()).flat_map(of_tilt).collect();
        let mut a = DMatrix::zeros(3 * cells.len(), 3 * grid.nests.len() + 6 * grid.tilts_rad.len());
        let mut b = DVector::zeros(3 * cells.len());
        for (n, (tilt, s, cell)) in cells.iter().enumerate() {
            a.fixed_view_mut::<3, 3>(3 * n, 3 * s).fill_with_identity();
            let [translations, rotations] = cell.columns(&cell.tilting);
            a.fixed_view_mut::<3, 3>(3 * n, self.of_tilt[*tilt]).copy_from(&translations);
            a.fixed_view_mut::<3, 3>(3 * n, self.of_tilt[*tilt] + 3).copy_from(&rotations);
            b.fixed_rows_mut::<3>(3 * n).copy_from(&cell.mean_mm);
        }
        (a, b)
    }
}

fn twist_of(x: &DVector<f64>, from: usize) -> Twist {
    Twist {
        translation_mm: x.fixed_rows::<3>(from).into_owned(),
        rotation_rad: x.fixed_rows::<3>(from + 3).into_owned(),
    }
}
