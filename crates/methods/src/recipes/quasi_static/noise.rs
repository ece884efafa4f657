//! u of the quasi-static part under the noise that the readings of all sweeps show together.
//!
//! p_k is linear in the readings of sweep k, and the part is the sum of c_k p_k: so it is linear in the readings of all sweeps. The noise is learned
//! next to all parts of all errors, and to what each sweep determines besides; it holds the drift that all sweeps share, which their scatter cannot
//! show [docs/design/statistics.md §1]. Parts that differ from sweep to sweep are left to the scatter, which shows all that moves them.

use super::read::Read;
use crate::recipes::MethodError;
use nalgebra::{DMatrix, DVector};
use trunnion_cycles::Run;
use trunnion_engine::solve::linear::least_squares;
use trunnion_engine::{BeyondModel, Experiment, ReadingNoise};

/// Relative singular value below which parts are not separated.
const TOLERANCE: f64 = 1e-9;

/// Of each error, inside units. `None` where the readings do not say what is noise. `design`: what each part counts in each sweep;
/// `from_sweeps`: what each sweep counts in the quasi-static part.
pub(super) fn u_of_quasi_static(
    runs: &[Run],
    sweeps: &[&Read],
    design: &DMatrix<f64>,
    from_sweeps: &[f64],
) -> Result<Option<DVector<f64>>, MethodError> {
    let (experiment, point_of) = experiment(runs, sweeps)?;
    let (errors, parts) = (sweeps[0].of_errors.ncols(), design.ncols());
    let others: usize = sweeps.iter().map(|read| read.of_others.ncols()).sum();
    let mut columns = DMatrix::zeros(experiment.rows(), errors * parts + others);
    let mut shares = DMatrix::zeros(experiment.rows(), errors);
    let mut deviation_mm = DVector::zeros(experiment.rows());
    let mut used = vec![true; experiment.points.len()];
    let mut first_other = errors * parts;
    for (k, read) in sweeps.iter().enumerate() {
        let mut row = 0;
        for (&point, &is_used) in point_of[k].iter().zip(&read.used) {
            used[point] = is_used;
            for to in experiment.rows_of(point) {
                for error in 0..errors {
                    shares[(to, error)] = read.shares[(row, error)] * from_sweeps[k];
                    for part in 0..parts {
                        columns[(to, error * parts + part)] =
                            read.of_errors[(row, error)] * design[(k, part)];
                    }
                }
                let mut of_others = columns.view_mut((to, first_other), (1, read.of_others.ncols()));
                of_others.copy_from(&read.of_others.row(row));
                deviation_mm[to] = read.deviation_mm[row];
                row += 1;
            }
        }
        first_other += read.of_others.ncols();
    }
    let left_mm = &deviation_mm - &columns * least_squares(&columns, &deviation_mm, TOLERANCE).x;
    let noise = ReadingNoise::next_to(&experiment, &columns, &left_mm, &used);
    Ok(noise.map(|noise| noise.u(&shares, BeyondModel::NOTHING)))
}

/// The readings of all sweeps in the order they were taken; for each sweep the points that are its readings.
fn experiment(runs: &[Run], sweeps: &[&Read]) -> Result<(Experiment, Vec<Vec<usize>>), MethodError> {
    let (mut kept, mut point_of) = (Vec::new(), vec![Vec::new(); sweeps.len()]);
    let mut count = 0;
    for (of_run, run) in runs.iter().enumerate() {
        let good: Vec<_> = run.good_points().collect();
        let mut place = vec![None; good.len()];
        let own = |read: &&Read| read.of_run == of_run;
        sweeps
            .iter()
            .filter(|read| own(read))
            .flat_map(|read| &read.numbers)
            .for_each(|&k| place[k] = Some(0));
        for of_point in place.iter_mut().flatten() {
            *of_point = count;
            count += 1;
        }
        for (of_sweep, read) in point_of.iter_mut().zip(sweeps).filter(|(_, read)| own(read)) {
            of_sweep.extend(read.numbers.iter().filter_map(|&k| place[k]));
        }
        let points = good.into_iter().zip(&place).filter(|(_, place)| place.is_some());
        kept.push(Run { points: points.map(|(point, _)| point.clone()).collect(), ..run.clone() });
    }
    Ok((Experiment::of_points(&kept)?, point_of))
}
