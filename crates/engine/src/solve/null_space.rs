//! What the data cannot see: null directions of the scaled design, made sparse and named.
//!
//! Null vectors are all directions of the scaled columns that show no more than rounding and positions a little off the commanded ones
//! would show by themselves (`problem::off_nominal`), and those along which the fit would wander by more than `MEANINGLESS_MM` of
//! reading or did not come to rest. They are brought to reduced row echelon form (`solve::echelon`). Every pivot is held at zero, which leaves independent
//! columns. A parameter that a direction moves by less than its u takes no part in it; its u then holds that much
//! ([`of_null_directions`]). This is done in two stages, for the role of an effect decides who keeps a number (docs/decisions/0004-datum-convention.md).
//!
//! 1. Location errors and settings alone. Pivots are first the parameters that the minimum set of location errors defines as zero
//!    (S2 tables 2–5), weakest first, then the most involved ones. One whose zero asks more than ten times their usual size of others comes
//!    last: a shift of a head of a few mm between its axes would be a turn of 1 mrad for each µm. A conventional pivot lets the others of its direction stand
//!    for it; any other pivot leaves its whole direction without numbers. Of parameters involved alike the pivot is the one whose
//!    zero asks least of the others: of a tilt and a zero of the reading, 15 mm apart, the tilt. Were the zero held, a dead path of
//!    10 mm would be a tilt of 40°.
//!    Where nobody keeps the share, a parameter that the direction moves by little of its usual size keeps its number with a wider u.
//! 2. What stage 1 determines next to the parameters of causes, error motions and descriptions. The most involved of these are
//!    pivots: no parameter of them in the direction gets a number, the location errors and settings in it keep theirs.
//!
//! So an effect that is added to a model takes no number from the location errors and settings.

use crate::solve::direction::Status;
use crate::solve::echelon::{Preferred, Row, echelon};
use crate::solve::linear::Reduced;
use crate::solve::unseen::unseen;
use nalgebra::{DMatrix, DVector, RowDVector};
use trunnion_effects::{Parameter, Unit};

/// A direction whose uncertainty moves the readings by more than this (rms, mm) has no physical meaning.
const MEANINGLESS_MM: f64 = 1.0;
/// A parameter that moves the readings less than this (rms, mm for each mm, or for each rad) is not seen: what is left of its
/// column is rounding and the mean of blocks.
const FAINTEST_PER_MM: f64 = 1e-6;
const FAINTEST_PER_RAD_MM: f64 = 1e-4;
/// Share of a direction (scaled columns) above which a parameter takes part: by rounding, and for weak directions.
const TAKES_PART: f64 = 1e-6;
const TAKES_PART_WEAKLY: f64 = 1e-3;
/// Standard deviations of what positions off by chance make of a share: more are its own.
const CHANCE: f64 = 3.0;
/// Usual size of an error of a machine, generous: what machines are aligned to. A direction along which the readings leave an error of
/// the machine more uncertain than this says nothing of it, and no null direction is longer.
const USUAL_MM: f64 = 1.0;
/// The same of a setting, which a hand left where it is.
const SETTING_MM: f64 = 10.0;
/// Who moves by less than its u while a null direction is so many times longer than usual takes no part in it. A zero by convention asks no more
/// of others than this.
const TIMES_USUAL: f64 = 10.0;
/// Where nobody keeps the share of a null direction, a parameter keeps its number when the direction, as long as usual, moves it by less
/// than this part of its own usual size: 50 µm for a tilt of 1 mrad that is not known. Its u then holds that.
const LITTLE: f64 = 0.05;
/// An angle counts as much as the length that it moves at this distance, mm: the reach of a machine.
const REACH_MM: f64 = 1e3;
/// What a setting counts, a dead path of metres or a form of micrometres: it is the pivot where there is nothing else, by its share.
const ANY_SIZE: f64 = 1e-9;

/// How the null space is fixed.
pub(crate) struct Datum {
    /// Columns left to determine; independent.
    pub determined: Vec<usize>,
    /// Status of every parameter.
    pub status: Vec<Status>,
    /// The directions.
    pub directions: Vec<Direction>,
    /// Rank before any convention.
    pub rank: usize,
}

/// One null vector.
pub(crate) struct Direction {
    /// Parameter index and coefficient, inside units, the pivot first with coefficient 1.
    pub terms: Vec<(usize, f64)>,
    pub share: Share,
    /// True when the direction is not exactly null, only too weak.
    pub weak: bool,
    /// How far it moves, at its longest, those that take no part in it: parameter index and amount, inside units.
    pub moved: Vec<(usize, f64)>,
    /// Those of them that would have no number did they take part.
    pub widened: Vec<usize>,
}

/// Who keeps the share of a null direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Share {
    /// The others: the pivot is zero by convention.
    Others,
    /// The mounting: the axis of the pivot stands still in these runs.
    Mounting,
    /// Location errors and settings of the direction; what was added to them gets no number.
    Base,
    /// Nobody.
    Nobody,
}

/// Parameters that the data may determine.
pub(crate) struct Free {
    /// Of location errors and settings.
    pub base: Vec<usize>,
    /// Those of them that are settings.
    pub settings: Vec<usize>,
    /// Of all other effects.
    pub added: Vec<usize>,
}

/// What decides that a direction is not seen.
pub(crate) struct Limits<'a> {
    /// Relative singular value.
    pub tolerance: f64,
    /// ΔAᵀΔA of positions a little off.
    pub off_nominal: &'a DMatrix<f64>,
    /// Singular value (scaled columns, mm) below which the uncertainty is beyond meaning; 0 when noise is not known yet.
    pub weakest: f64,
    /// Number of rows.
    pub rows: usize,
    /// Those that a direction moves, at least: the rows of one setup.
    pub rows_moved: f64,
}

impl Limits<'_> {
    /// The same for a residual standard deviation.
    pub fn with_noise(&self, sigma_mm: f64, rows: usize) -> Self {
        Self { weakest: sigma_mm / (MEANINGLESS_MM * (rows as f64).sqrt()), rows, ..*self }
    }

    /// The residual standard deviation, mm; 0 when it is not known yet.
    fn noise_mm(&self) -> f64 {
        self.weakest * MEANINGLESS_MM * (self.rows as f64).sqrt()
    }

    /// ΔAᵀΔA of the scaled columns `of`: what they would show if positions alone were a little off.
    fn off_nominal(&self, reduced: &Reduced, of: &[usize]) -> DMatrix<f64> {
        let scale = |k: usize| reduced.scale[of[k]];
        let scaled = |k: usize, l: usize| scale(k) * self.off_nominal[(of[k], of[l])] * scale(l);
        // An effect may have no finite value a little off the positions; a decomposition would never end.
        DMatrix::from_fn(of.len(), of.len(), |k, l| {
            Some(scaled(k, l)).filter(|x| x.is_finite()).unwrap_or(0.0)
        })
    }

    /// True when a parameter moves the readings by less than means anything (rms, mm for each mm or rad), or by no more than
    /// positions a little off would make it.
    fn faint(&self, reduced: &Reduced, parameters: &[Parameter], j: usize) -> bool {
        let faintest = match parameters[j].unit {
            Unit::UM => FAINTEST_PER_MM,
            Unit::URAD => FAINTEST_PER_RAD_MM,
            _ => 0.0,
        };
        let norm = reduced.triangle.column(j).norm() / reduced.scale[j];
        norm < faintest * (self.rows as f64).sqrt() || norm * norm <= self.off_nominal[(j, j)]
    }
}

/// The length that one unit of a parameter stands for, mm.
fn length_mm(parameter: &Parameter) -> f64 {
    if parameter.unit == Unit::URAD { REACH_MM } else { 1.0 }
}

/// A parameter that by convention is zero when it is confounded with others.
pub(crate) struct Zero {
    /// Name of the parameter.
    pub name: String,
    /// True when its axis stands still in these runs, so that its line shows nowhere.
    pub standing: bool,
}

pub(crate) fn datum(
    reduced: &Reduced,
    free: &Free,
    parameters: &[Parameter],
    zeros: &[Zero],
    limits: &Limits<'_>,
) -> Datum {
    let fixed = Datum {
        determined: Vec::new(),
        status: vec![Status::Held; parameters.len()],
        directions: Vec::new(),
        rank: 0,
    };
    let mut work = Work { reduced, parameters, limits, settings: &free.settings, datum: fixed };
    let base = work.those_with_effect(&free.base);
    work.fix(base, Pivots::Zeros(zeros));
    let added = work.those_with_effect(&free.added);
    if !added.is_empty() {
        let of = work.datum.determined.iter().chain(&added).copied().collect();
        work.fix(of, Pivots::Added(&added));
    }
    work.datum
}

/// Which parameters of a null direction are held at zero first.
enum Pivots<'a> {
    Zeros(&'a [Zero]),
    Added(&'a [usize]),
}

struct Work<'a> {
    reduced: &'a Reduced,
    parameters: &'a [Parameter],
    limits: &'a Limits<'a>,
    settings: &'a [usize],
    datum: Datum,
}

impl Work<'_> {
    /// Those that move the readings; the others get no number.
    fn those_with_effect(&mut self, free: &[usize]) -> Vec<usize> {
        let (without, with): (Vec<usize>, Vec<usize>) =
            free.iter().partition(|&&j| self.limits.faint(self.reduced, self.parameters, j));
        for j in without {
            self.datum.status[j] = Status::Unobservable;
            let direction = Direction {
                terms: vec![(j, 1.0)],
                share: Share::Nobody,
                weak: false,
                moved: Vec::new(),
                widened: Vec::new(),
            };
            self.datum.directions.push(direction);
        }
        for &j in &with {
            self.datum.status[j] = Status::Identified;
        }
        with
    }

    /// How many times its usual size a parameter is for its share in a direction: the pivot is what a zero suits best.
    fn count(&self, j: usize) -> f64 {
        let usual = match self.parameters[j].u_beforehand {
            Some(u) => u,
            None if self.settings.contains(&j) => return ANY_SIZE,
            None => USUAL_MM / length_mm(&self.parameters[j]),
        };
        self.reduced.scale[j] / usual
    }

    /// A scaled parameter at 1, as a part of what it is at most along a null direction.
    fn of_longest(&self, j: usize) -> f64 {
        let most_mm = if self.settings.contains(&j) { SETTING_MM } else { USUAL_MM };
        self.reduced.scale[j] * length_mm(&self.parameters[j]) / most_mm
    }

    /// Holds a pivot of each null direction of the columns `of` at zero; the rest is determined.
    fn fix(&mut self, of: Vec<usize>, pivots: Pivots<'_>) {
        if of.is_empty() {
            return;
        }
        let place = |j: usize| of.iter().position(|&k| k == j);
        let named = |zero: &Zero| of.iter().position(|&j| self.parameters[j].name == zero.name);
        let (mut preferred, mut standing, mut first) = (Vec::new(), Vec::new(), Vec::new());
        match pivots {
            Pivots::Zeros(zeros) => {
                (preferred, standing) =
                    zeros.iter().filter_map(|zero| Some((named(zero)?, zero.standing))).unzip();
            }
            Pivots::Added(added) => first = added.iter().filter_map(|&j| place(j)).collect(),
        }
        // A scaled parameter at 1, as a part of its longest; the same of errors that a machine is aligned to, 0 for others. Nobody aligns a cause: two
        // drifts of nearly one time constant are uncertain by millimetres, and what they do together is seen.
        let of_longest: Vec<f64> = of.iter().map(|&j| self.of_longest(j)).collect();
        let is_aligned = |k: usize, j: &usize| {
            let is_error = matches!(self.parameters[*j].unit, Unit::UM | Unit::URAD);
            is_error && !self.settings.contains(j) && !first.contains(&k)
        };
        let of_usual: Vec<f64> =
            of.iter().enumerate().map(|(k, j)| if is_aligned(k, j) { of_longest[k] } else { 0.0 }).collect();
        let Null { vectors, weak, off, least, root_cofactor } =
            null(self.reduced, &of, &of_usual, self.limits);
        self.datum.rank = of.len() - vectors.nrows();
        let counts: Vec<f64> = of.iter().map(|&j| self.count(j)).collect();
        let noise_mm = self.limits.noise_mm();
        let least_shares = |row: &RowDVector<f64>| {
            let off_mm =
                CHANCE * (row * &off * row.transpose())[0].max(0.0).sqrt() / self.limits.rows_moved.sqrt();
            let unfelt_mm = noise_mm * largest(row.iter(), &of_longest) / TIMES_USUAL;
            root_cofactor.iter().map(|root| (root * off_mm.max(unfelt_mm)).max(least)).collect()
        };
        let zeros = Preferred { columns: &preferred, of_usual: &of_longest, most: TIMES_USUAL };
        let rows = echelon(vectors, &zeros, &first, &counts, &least_shares);
        let held: Vec<usize> = rows.iter().map(|row| of[row.pivot]).collect();
        for mut row in rows {
            let pivot = row.pivot;
            let share_of = |row: &Row| match preferred.iter().position(|&zero| zero == pivot) {
                Some(k) if standing[k] => Share::Mounting,
                Some(_) => Share::Others,
                None if first.contains(&pivot) && row.others().iter().any(|k| !first.contains(k)) => {
                    Share::Base
                }
                None => Share::Nobody,
            };
            let longest = largest(row.part.iter(), &of_longest).recip();
            let mut widened = Vec::new();
            if share_of(&row) == Share::Nobody {
                let little = |k: usize, entry: f64| entry.abs() * longest * of_usual[k] < LITTLE;
                widened = row.leave_out(|k, entry| of_usual[k] > 0.0 && little(k, entry));
            }
            let (share, others) = (share_of(&row), row.others());
            let conventional = matches!(share, Share::Others | Share::Mounting);
            let status = &mut self.datum.status;
            status[of[pivot]] = if conventional { Status::ZeroByConvention } else { Status::Unobservable };
            let without_number = others.iter().filter(|k| match share {
                Share::Others | Share::Mounting => false,
                Share::Base => first.contains(k),
                Share::Nobody => true,
            });
            without_number.for_each(|&k| status[of[k]] = Status::Unobservable);
            let scale = |k: usize| self.reduced.scale[of[k]];
            let term = |k: usize| (of[k], row.part[k] * scale(k) / scale(pivot));
            let terms = std::iter::once(pivot).chain(others).map(term).collect();
            // A cause has no usual size in its own unit: what an unknown one moves by chance is not counted.
            let rest = (0..of.len()).filter(|&k| first.is_empty() && row.rest[k] != 0.0);
            let moved = rest.map(|k| (of[k], row.rest[k] * longest * scale(k))).collect();
            let widened = widened.into_iter().map(|k| of[k]).collect();
            self.datum.directions.push(Direction { terms, share, weak, moved, widened });
        }
        self.datum.determined = of.into_iter().filter(|j| !held.contains(j)).collect();
    }
}

/// The entry that is largest in its own unit; `units`: of what it is at 1.
fn largest<'a>(entries: impl Iterator<Item = &'a f64>, units: &[f64]) -> f64 {
    entries.zip(units).map(|(entry, unit)| entry.abs() * unit).fold(0.0, f64::max)
}

/// Covariance of the determined parameters from null directions in which they take no part: d dᵀ for each, d what the direction moves at
/// its longest [GUM F.2.4.5].
pub(crate) fn of_null_directions(datum: &Datum) -> DMatrix<f64> {
    let width = datum.determined.len();
    let mut sum = DMatrix::zeros(width, width);
    for direction in &datum.directions {
        let mut moved = DVector::zeros(width);
        for &(j, amount) in &direction.moved {
            if let Some(k) = datum.determined.iter().position(|other| *other == j) {
                moved[k] = amount;
            }
        }
        sum.ger(1.0, &moved, &moved, 1.0);
    }
    sum
}

/// What some columns do not show.
struct Null {
    /// Null vectors of the scaled columns, orthonormal rows.
    vectors: DMatrix<f64>,
    /// True when some are not exactly null, only too weak.
    weak: bool,
    /// ΔAᵀΔA of the scaled columns.
    off: DMatrix<f64>,
    /// Share of a unit vector from which a parameter takes part in it, by rounding.
    least: f64,
    /// Roots of the diagonal of (AᵀA)⁻¹ in what is seen: u of each parameter for noise of 1 mm.
    root_cofactor: Vec<f64>,
}

/// Unseen are all v with ‖A v‖ ≤ ‖ΔA v‖, found together: singular vectors of A alone mix what is seen with what is not, and other
/// positions mix them otherwise [Van Loan 1976].
///
/// Of what is seen, those are too weak that noise alone moves by more than means anything: readings by [`MEANINGLESS_MM`], or a
/// parameter by more than 1 / `of_usual`.
///
/// Positions off by chance turn a null vector v by A⁺ ΔA v: parameter j by ‖ΔA v‖/√m times the root of its (AᵀA)⁻¹, m the readings that v
/// moves.
fn null(reduced: &Reduced, of: &[usize], of_usual: &[f64], limits: &Limits<'_>) -> Null {
    let triangle = reduced.triangle.select_columns(of);
    let off = limits.off_nominal(reduced, of);
    let floor = limits.tolerance.max(reduced.floor) * triangle.singular_values().amax();
    let unseen = unseen(&triangle, off.clone(), floor);
    let others = DMatrix::identity(of.len(), of.len()) - unseen.transpose() * &unseen;
    let (sigma, v_t) = Reduced::singular_of(&triangle * others);
    let weakest = |i: usize| limits.weakest.max(limits.noise_mm() * largest(v_t.row(i).iter(), of_usual));
    let (faint, seen): (Vec<usize>, Vec<usize>) =
        (0..of.len() - unseen.nrows()).partition(|&i| sigma[i] < weakest(i));
    let faint = v_t.select_rows(&faint);
    let weak = faint.nrows() > 0;
    let rows: Vec<_> = unseen.row_iter().chain(faint.row_iter()).collect();
    let vectors = if rows.is_empty() { DMatrix::zeros(0, of.len()) } else { DMatrix::from_rows(&rows) };
    let least = if weak { TAKES_PART_WEAKLY } else { TAKES_PART };
    let root_cofactor = |j: usize| seen.iter().map(|&i| (v_t[(i, j)] / sigma[i]).powi(2)).sum::<f64>().sqrt();
    Null { vectors, weak, off, least, root_cofactor: (0..of.len()).map(root_cofactor).collect() }
}

#[cfg(test)]
mod tests;
