//! What machines do in addition to what they are asked: the kernels of the noise, as data.
//!
//! Each has a frame (in what it acts), pairs of points that it moves alike, and what is expected of its size. A free correlation time
//! or length is a mixture of a few fixed ones with free sizes: every unknown is then a logarithm of a size. The expected sizes say
//! "about a seventh to a quarter of the noise of a single reading, perhaps eight times as much" (σ of the logarithm 1.2): they matter where a run has few
//! degrees of freedom, such as two passes. Where a row is a mean of many readings its white noise is smaller than theirs; what machines do is not.

use super::Real;
use super::field::Axes;
use super::frame::{Frame, of_axis, of_machine, of_readings};
use super::kernel::{Kernel, Over, Part};
use crate::Experiment;
use crate::problem::taken::Taken;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// σ of ln ρ.
const SPREAD_LN: f64 = 1.2;
/// The same of angles at which axes stop: maker's data say more of them.
const SPREAD_OF_ANGLES_LN: f64 = 1.0;
/// What a channel scatters beyond the quietest one, in units of the white noise of a row: channels of like probes differ by some tenths.
const OF_CHANNEL: f64 = 0.3;
/// Correlation times of drift, as shares of the span from four points to the whole run, in logarithms: shorter ones look like
/// white noise, longer ones like a constant.
const DRIFT_OF_READINGS: [f64; 3] = [0.0, 0.5, 1.0];
const DRIFT_OF_MACHINE: [f64; 2] = [0.3, 0.9];
const SHORTEST_DRIFT_POINTS: f64 = 4.0;
/// The same of smooth drift where no rotary axis moves: there position may grow with time alone, as on a line measured one way, so
/// that a smooth drift is a smooth error of the axis.
const SMOOTH_DRIFT: [f64; 2] = [0.7, 1.0];
/// The same of their sizes: a wider one takes every scale for drift, a narrower one takes drift for a scale
/// (docs/measured/worlds.md, lines).
const SPREAD_OF_SMOOTH_LN: f64 = 1.0;
/// Poses that come back at least this often on average make a pattern without any smoothness visible.
const REPEATED: f64 = 1.25;
/// Kernels of one frame whose pairs are this much alike are one.
const SAME: f64 = 0.999;

/// All kernels on the points of one experiment.
pub(crate) struct Kernels {
    pub list: Vec<Kernel>,
    pub frames: Vec<Frame>,
    pub points: usize,
    pub point_of_row: Arc<[usize]>,
    pub rows_of_point: Vec<Range<usize>>,
    /// Readings of every point, where all have as many.
    components: Option<usize>,
    /// Noise of a single reading, in units of the white noise of a row.
    pub single: f64,
}

impl Kernels {
    /// `root`: roots of the weights of the rows; the white part stays 1, the others follow the rows.
    /// `single`: noise of a single reading, in units of the white noise of a row.
    pub fn new(experiment: &Experiment, root: &DVector<f64>, single: f64) -> Self {
        let points = experiment.points.len();
        let rows_of_point: Vec<Range<usize>> = (0..points).map(|i| experiment.rows_of(i)).collect();
        let point_of_row: Arc<[usize]> =
            rows_of_point.iter().enumerate().flat_map(|(i, rows)| rows.clone().map(move |_| i)).collect();
        let components = rows_of_point.first().map(Range::len);
        let components = components.filter(|&count| rows_of_point.iter().all(|rows| rows.len() == count));
        let (list, frames) = (Vec::new(), Vec::new());
        let mut kernels = Self { list, frames, points, point_of_row, rows_of_point, components, single };
        let taken = Taken::new(experiment);
        let axes = Axes::new(experiment, &taken);
        let channels = of_readings(experiment);
        let mut readings = In::frame(&mut kernels, channels.clone(), root);
        readings.add(Part::Pass, same_group(&taken.pass), 0.25, SPREAD_LN);
        // On a line what all passes of one way share is backlash by definition, once a way was gone more than once.
        if !axes.turning.is_empty() || count(&taken.pass) <= count(&taken.heading) {
            readings.add(Part::Pass, same_group(&taken.heading), 0.25, SPREAD_LN);
        }
        readings.add(Part::Pass, same_group(&taken.visit), 0.25, SPREAD_LN);
        readings.add(Part::Station, same_group(&taken.station), 0.12, SPREAD_LN);
        for tau in taken.times(DRIFT_OF_READINGS, SHORTEST_DRIFT_POINTS) {
            readings.add(Part::Drift, taken.drift(tau), 0.15, SPREAD_LN);
        }
        if axes.turning.is_empty() {
            readings.add(Part::Drift, taken.trend(), 0.1, SPREAD_OF_SMOOTH_LN);
            for tau in taken.times(SMOOTH_DRIFT, SHORTEST_DRIFT_POINTS) {
                readings.add(Part::Drift, taken.smooth_drift(tau), 0.1, SPREAD_OF_SMOOTH_LN);
            }
        }
        if f64::from(count(&taken.pose)) * REPEATED < points as f64 && !axes.turning.is_empty() {
            readings.add(Part::Pattern, same_group(&taken.pose), 0.1, SPREAD_LN);
        }
        for (mean, lengths) in axes.lengths_of_readings() {
            readings.add(Part::Pattern, axes.field(&lengths), mean, SPREAD_LN);
        }
        for channel in channels.column_iter().filter(|_| channels.ncols() > 1) {
            let of_one = DMatrix::from_columns(&[channel]);
            // The size of a kernel is that of its mean over all rows.
            let mean_ln = (OF_CHANNEL * of_one.norm() / (of_one.nrows() as f64).sqrt()).ln();
            In::frame(&mut kernels, of_one, root).own(Part::Channel, mean_ln, SPREAD_LN);
        }
        if axes.turning.is_empty() {
            return kernels;
        }
        let mut machine = In::frame(&mut kernels, of_machine(experiment), root);
        machine.add(Part::Pass, same_group(&taken.pass), 0.15, SPREAD_LN);
        for tau in taken.times(DRIFT_OF_MACHINE, SHORTEST_DRIFT_POINTS) {
            machine.add(Part::Drift, taken.drift(tau), 0.1, SPREAD_LN);
        }
        for (mean, lengths) in axes.lengths_of_machine() {
            machine.add(Part::Pattern, axes.field(&lengths), mean, SPREAD_LN);
        }
        if let Some(slow) = taken.slow {
            In::frame(&mut kernels, of_axis(experiment, slow), root).add(
                Part::Station,
                same_group(&taken.station),
                0.2,
                SPREAD_OF_ANGLES_LN,
            );
        }
        if let Some(fast) = taken.fast {
            let mean_ln = (0.2 * single).ln();
            In::frame(&mut kernels, of_axis(experiment, fast), root).own(
                Part::Station,
                mean_ln,
                SPREAD_OF_ANGLES_LN,
            );
        }
        kernels
    }

    /// Of points with one reading each: part, pairs and expected size of every kernel.
    #[cfg(test)]
    pub fn of_one_channel(kernels: Vec<(Part, DMatrix<Real>, f64)>) -> Self {
        let points = kernels.first().map_or(0, |(_, pairs, _)| pairs.nrows());
        let point_of_row: Arc<[usize]> = (0..points).collect();
        let lever = DMatrix::from_element(points, 1, 1.0);
        let frames = Frame::new(&lever, points, Arc::clone(&point_of_row)).into_iter().collect();
        let kernel = |(part, pairs, mean): (Part, DMatrix<Real>, f64)| Kernel {
            part,
            frame: super::kernel::OF_READINGS,
            over: Over::Pairs(pairs),
            mean_ln: mean.ln(),
            spread_ln: SPREAD_LN,
        };
        let list = kernels.into_iter().map(kernel).collect();
        let rows_of_point = (0..points).map(|point| point..point + 1).collect();
        Self { list, frames, points, point_of_row, rows_of_point, components: Some(1), single: 1.0 }
    }

    /// The same kernels on some of the points.
    pub fn on(&self, chosen: &[usize]) -> Self {
        let rows: Vec<usize> = chosen.iter().flat_map(|&point| self.rows_of_point[point].clone()).collect();
        let over = |over: &Over| match over {
            Over::Pairs(pairs) => Over::Pairs(DMatrix::from_fn(chosen.len(), chosen.len(), |i, j| {
                pairs[(chosen[i], chosen[j])]
            })),
            Over::Own => Over::Own,
        };
        let mut next = 0;
        let rows_of_point: Vec<Range<usize>> = chosen
            .iter()
            .map(|&point| {
                let first = next;
                next += self.rows_of_point[point].len();
                first..next
            })
            .collect();
        let point_of_row: Arc<[usize]> =
            rows_of_point.iter().enumerate().flat_map(|(i, rows)| rows.clone().map(move |_| i)).collect();
        let frame = |frame: &Frame| frame.on(&rows, chosen.len(), Arc::clone(&point_of_row));
        let list = self.list.iter().map(|kernel| Kernel { over: over(&kernel.over), ..*kernel }).collect();
        Self {
            list,
            frames: self.frames.iter().map(frame).collect(),
            points: chosen.len(),
            point_of_row,
            rows_of_point,
            components: self.components,
            single: self.single,
        }
    }

    /// Σ over the rows of each point of the blocks of `matrix` ∘ lever · leverᵀ on its diagonal.
    pub fn contracted_own(&self, frame: &Frame, matrix: &DMatrix<Real>) -> DVector<Real> {
        let mut gram = Vec::new();
        let of_point = |rows: &Range<usize>| {
            let of_column = |column: usize| {
                frame.gram(column, rows.clone(), &mut gram);
                matrix
                    .view((rows.start, column), (rows.len(), 1))
                    .iter()
                    .zip(&gram)
                    .map(|(a, b)| a * b)
                    .sum::<Real>()
            };
            rows.clone().map(of_column).sum()
        };
        DVector::from_iterator(self.points, self.rows_of_point.iter().map(of_point))
    }

    /// Variance of every row by the kernels of white noise at these ρ², in units of s².
    pub fn white_of_rows(&self, rho_squared: &[f64]) -> DVector<f64> {
        let mut variance = DVector::zeros(self.point_of_row.len());
        for (kernel, rho_squared) in self.list.iter().zip(rho_squared).filter(|(kernel, _)| kernel.is_white())
        {
            self.frames[kernel.frame].add_squares(*rho_squared, &mut variance);
        }
        variance
    }

    /// Whether a kernel of a frame moves points alike.
    pub fn has_pairs(&self, frame: usize) -> bool {
        self.list.iter().any(|kernel| kernel.frame == frame && matches!(kernel.over, Over::Pairs(_)))
    }

    /// Σ over the rows of each pair of points of `matrix` ∘ lever · leverᵀ.
    pub fn contracted(&self, frame: &Frame, matrix: &DMatrix<Real>) -> DMatrix<Real> {
        let (rows, points) = (matrix.nrows(), self.points);
        let (mut sums, mut gram) = (DMatrix::zeros(points, points), Vec::new());
        for column in 0..rows {
            let of_point = self.point_of_row[column] * points;
            let target = &mut sums.as_mut_slice()[of_point..of_point + points];
            let a = &matrix.as_slice()[column * rows..(column + 1) * rows];
            frame.gram(column, 0..rows, &mut gram);
            match self.components {
                Some(1) => contract::<1>(target, a, &gram),
                Some(3) => contract::<3>(target, a, &gram),
                _ => {
                    for ((a, b), &point) in a.iter().zip(&gram).zip(self.point_of_row.iter()) {
                        target[point] += a * b;
                    }
                }
            }
        }
        sums
    }

    /// Adds, to the rows of a column of a covariance from point `first` on, gram ∘ the values of the rows' points.
    pub fn add_expanded(&self, first: usize, target: &mut [Real], gram: &[Real], of_points: &[Real]) {
        match self.components {
            Some(1) => expand::<1>(target, gram, &of_points[first..]),
            Some(3) => expand::<3>(target, gram, &of_points[first..]),
            _ => {
                let points = &self.point_of_row[self.rows_of_point[first].start..];
                for ((value, gram), &point) in target.iter_mut().zip(gram).zip(points) {
                    *value += gram * of_points[point];
                }
            }
        }
    }

    /// Cᵀ K_k C of every kernel.
    pub fn through(&self, columns: &DMatrix<Real>) -> Vec<DMatrix<f64>> {
        let width = columns.ncols();
        // Of every frame: the directions next to each other, and each transposed.
        let folded = |frame: &Frame| {
            let folded = frame.folded_columns(columns);
            let directions = (0..folded.ncols()).step_by(width.max(1));
            let across: Vec<DMatrix<Real>> =
                directions.map(|first| folded.columns(first, width).transpose()).collect();
            (folded, across)
        };
        let folded: Vec<(DMatrix<Real>, Vec<DMatrix<Real>>)> = self.frames.iter().map(folded).collect();
        let of_kernel = |kernel: &Kernel| {
            let (folded, across) = &folded[kernel.frame];
            // One product for all directions: the pairs are copied once on the way into it.
            let moved = match &kernel.over {
                Over::Own => Cow::Borrowed(folded),
                Over::Pairs(pairs) => Cow::Owned(pairs * folded),
            };
            let of_direction =
                |(k, across): (usize, &DMatrix<Real>)| across * moved.columns(k * width, width);
            let products = across.iter().enumerate().map(of_direction);
            let sum: DMatrix<f64> =
                products.fold(DMatrix::zeros(width, width), |sum, product| sum + product.cast::<f64>());
            (&sum + sum.transpose()) * 0.5
        };
        self.list.iter().map(of_kernel).collect()
    }

    /// ln of what is expected of every size.
    pub fn means(&self) -> impl Iterator<Item = f64> + '_ {
        self.list.iter().map(|kernel| kernel.mean_ln)
    }
}

/// Sums over the N rows of each point of a ∘ b.
fn contract<const N: usize>(target: &mut [Real], a: &[Real], b: &[Real]) {
    for ((sum, a), b) in target.iter_mut().zip(a.chunks_exact(N)).zip(b.chunks_exact(N)) {
        *sum += a.iter().zip(b).map(|(a, b)| a * b).sum::<Real>();
    }
}

/// gram ∘ the value of each point, on its N rows.
fn expand<const N: usize>(target: &mut [Real], gram: &[Real], of_points: &[Real]) {
    for ((rows, gram), of_point) in target.chunks_exact_mut(N).zip(gram.chunks_exact(N)).zip(of_points) {
        for (value, gram) in rows.iter_mut().zip(gram) {
            *value += gram * of_point;
        }
    }
}

/// A frame on the way to its kernels.
struct In<'a> {
    kernels: &'a mut Kernels,
    frame: Option<usize>,
}

impl<'a> In<'a> {
    /// No kernel is added where the frame moves no reading.
    fn frame(kernels: &'a mut Kernels, mut lever: DMatrix<f64>, root: &DVector<f64>) -> Self {
        lever.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
        let frame = Frame::new(&lever, kernels.points, Arc::clone(&kernels.point_of_row));
        let frame = frame.map(|frame| {
            kernels.frames.push(frame);
            kernels.frames.len() - 1
        });
        Self { kernels, frame }
    }

    fn add(&mut self, part: Part, pairs: DMatrix<Real>, mean: f64, spread_ln: f64) {
        let Some(frame) = self.frame else { return };
        let norm = pairs.norm();
        let like = |kernel: &Kernel| match &kernel.over {
            Over::Pairs(other) => {
                kernel.frame == frame && pairs.dot(other) > SAME as Real * norm * other.norm()
            }
            Over::Own => false,
        };
        // One group of all points is the mounting, which the model has; one for every point is white.
        let points = pairs.nrows() as Real;
        if norm > SAME as Real * points || norm < 1.001 * points.sqrt() || self.kernels.list.iter().any(like)
        {
            return;
        }
        self.kernels.list.push(Kernel {
            part,
            frame,
            over: Over::Pairs(pairs),
            mean_ln: (mean * self.kernels.single).ln(),
            spread_ln,
        });
    }

    fn own(&mut self, part: Part, mean_ln: f64, spread_ln: f64) {
        let Some(frame) = self.frame else { return };
        self.kernels.list.push(Kernel { part, frame, over: Over::Own, mean_ln, spread_ln });
    }
}

/// 1 for two points of one group.
fn same_group(group: &[usize]) -> DMatrix<Real> {
    DMatrix::from_fn(group.len(), group.len(), |i, j| if group[i] == group[j] { 1.0 } else { 0.0 })
}

fn count(groups: &[usize]) -> u32 {
    groups.iter().max().map_or(0, |most| *most as u32 + 1)
}
