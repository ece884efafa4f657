//! The whole list fitted to one trace, each error's own circularity, and what is left.

use super::confounded::{Other, Together, confounded_together, one_number, others};
use super::drift::Drift;
use super::list::{Listed, ListedKind, columns, listed, of_beginnings, of_decay};
use super::sample::Sample;
use super::solved::{CENTRING, TOLERANCE, rounding, widened};
use super::trace::Trace;
use crate::common::bar::{OFF_TOLERANCE, read_mm, to_first_order};
use crate::common::rounding::{ROUNDING_MM, without};
use crate::common::stations::Stations;
use crate::geometry;
use crate::recipes::{Method, MethodError};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use std::ops::Range;
use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};
use trunnion_engine::solve::linear::{LinearFit, least_squares};
use trunnion_engine::{BeyondModel, Experiment, ReadingNoise};
use trunnion_machine::Machine;

/// Decays of a spike that are tried, as shares of the radius.
const DECAYS: [f64; 8] = [0.002, 0.0035, 0.006, 0.01, 0.015, 0.022, 0.033, 0.045];
/// Longest decay, as share of the radius: a longer one is hardly distinguished from backlash.
const LONGEST_DECAY: f64 = 0.05;
/// A spike must be this many times its uncertainty: its decay was chosen among many.
const SPIKE_STANDS_OUT: f64 = 5.0;

/// What is left may be this much more than noise before it says that the list lacks something.
const NOISE_AND_MORE: f64 = 1.5;

/// Angle (rad) and deviation (mm) in the order of the angle.
pub(super) type Contour = Vec<(f64, f64)>;

/// One trace, explained.
pub(super) struct Fitted<'a> {
    pub trace: &'a Trace,
    /// Largest circularity first.
    pub errors: Vec<FittedError>,
    /// Causes that are not on the list and read as errors of the list; why they could not be computed.
    pub others: Result<Vec<Other>, String>,
    /// Those that together leave nothing that shows them.
    pub together: Vec<Together>,
    /// Of the readings in time, where it is significant.
    pub drift: Option<Drift>,
    /// Values of ISO 230-4.
    pub iso: Iso,
    /// Standard deviation of what the centring leaves, mm.
    pub centred_rms_mm: f64,
    /// Of what the whole list leaves, mm.
    pub left_rms_mm: f64,
    /// Noise of one reading by second differences of what is left, mm.
    pub noise_mm: f64,
    /// Range of what is left, mean over stations, mm.
    pub left_circularity_mm: f64,
    /// Way, measured, explained, left; each centred, mean over stations.
    pub contours: Vec<(f64, [Contour; 3])>,
}

/// One error of the list as found.
#[derive(Clone)]
pub(super) struct FittedError {
    pub listed: Listed,
    /// Inside units; of a wave its amplitude.
    pub value: f64,
    /// Its part of the fit.
    pub x: DVector<f64>,
    /// Holds what a significant cause that is not on the list would move it by.
    pub u: f64,
    /// A smaller value is rounding.
    pub rounding: f64,
    /// Its columns of the fit.
    pub columns: Range<usize>,
    /// Range of what this error alone makes of the trace, centred, mm.
    pub circularity_mm: f64,
    /// s₀ of a spike, mm.
    pub decay_mm: Option<f64>,
}

impl FittedError {
    /// Beyond twice its standard uncertainty.
    pub fn significant(&self) -> bool {
        self.value.abs() > 2.0 * self.u
    }
}

/// ISO 230-4:2005, about least-squares centres, mm.
pub(super) struct Iso {
    /// Way and circular deviation G of each direction.
    pub g_mm: Vec<(f64, f64)>,
    /// Bidirectional circular deviation; `None` with one direction.
    pub g_b_mm: Option<f64>,
    /// Mean bidirectional radial deviation D: mean radius of both directions less nominal; `None` without a bar of known length.
    pub d_mm: Option<f64>,
    /// Radial deviation F, largest and smallest; `None` likewise.
    pub f_mm: Option<[f64; 2]>,
}

impl<'a> Fitted<'a> {
    /// Fits the list.
    ///
    /// # Errors
    /// A trace that goes around no circle.
    pub fn of(method: &Method, machine: &Machine, trace: &'a Trace) -> Result<Self, MethodError> {
        let list = listed(machine, trace);
        let samples = &trace.samples;
        let read = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.deviation_mm));
        let centring = DMatrix::from_fn(samples.len(), CENTRING, |i, k| centre_row(&samples[i])[k]);
        let centred = |of: &DVector<f64>| of - &centring * least_squares(&centring, of, TOLERANCE).x;
        let deviation = of_centre(trace, &centring, &read);
        let (list, decay_mm) = without_doubtful_spikes(trace, list, &deviation);
        let design = with_decays(trace, &list, decay_mm, design(trace, &list, decay_mm));
        let fit = least_squares(&design, &deviation, TOLERANCE);
        let left = (&deviation - &design * &fit.x).map(|mm| without(mm, ROUNDING_MM));
        let readings = trace.readings();
        let u_of_columns = u_of_columns(readings.as_ref().ok(), &design, &fit, &left);
        let kinds: Vec<ListedKind> = list.iter().map(|item| item.kind).collect();
        let others = readings.map(|readings| others(&readings, trace, &kinds, &design, &left));
        let mut errors = Vec::new();
        let mut first = CENTRING;
        for item in list {
            let count = columns(item.kind, trace, decay_mm, &samples[0]).len();
            let its = first..first + count;
            let of_columns = DVector::from_iterator(count, its.clone().map(|k| rounding(design.column(k))));
            let x = fit.x.rows(first, count).zip_map(&of_columns, without);
            let made = centred(&(design.columns(first, count) * &x));
            let own_u = u_of_columns.rows(first, count).norm() / (count as f64).sqrt();
            let moved = others.iter().flatten().map(|other| other.moved(&its)).fold(0.0, f64::max);
            errors.push(FittedError {
                value: one_number(&x),
                x,
                u: moved.hypot(without(own_u, of_columns.min())),
                rounding: of_columns.min(),
                columns: its,
                circularity_mm: range(made.iter().copied()),
                decay_mm: match item.kind {
                    ListedKind::ReversalSpike(k) => Some(decay_mm[k]),
                    _ => None,
                },
                listed: item,
            });
            first += count;
        }
        errors.sort_by(|a, b| b.circularity_mm.total_cmp(&a.circularity_mm));
        let measured = centred(&deviation).map(|mm| without(mm, ROUNDING_MM));
        let angles: Vec<f64> = trace.read.iter().map(|s| s.angle_rad).collect();
        let stations = match trace.on_the_fly {
            true => Stations::of_sweeps(&angles, true),
            false => Stations::of_grid(angles.iter().copied(), true),
        };
        let contour = |way: f64, of: &DVector<f64>| contour(&stations, samples, way, of);
        let explained = &measured - &left;
        let ways: Vec<f64> =
            [1.0, -1.0].into_iter().filter(|way| samples.iter().any(|s| s.way == *way)).collect();
        let contours: Vec<(f64, [Contour; 3])> = ways
            .iter()
            .map(|&way| (way, [&measured, &explained, &left].map(|of| contour(way, of))))
            .collect();
        // About the centre, where an angle of the bar is one of the circle; the mean radius stays.
        let setting = least_squares(&centring, &deviation, TOLERANCE).x;
        let setting_mm = Vector3::new(setting[1], setting[2], 0.0);
        let about_centre =
            |s: &Sample| (s.angle_rad, s.deviation_mm - read_mm(&bar_mm(trace, s), &setting_mm));
        let of_way = |way: f64| trace.read.iter().filter(move |sample| sample.way == way);
        let as_read = |&way: &f64| (way, stations.contour(of_way(way).map(about_centre)));
        let as_read: Vec<(f64, Contour)> = ways.iter().map(as_read).collect();
        let rms = |of: &DVector<f64>| of.norm() / (of.len() as f64).sqrt();
        let left_contours = contours.iter().flat_map(|(_, [.., left])| left.iter().map(|(_, v)| *v));
        let freedom = (samples.len() - fit.rank).max(1) as f64;
        Ok(Self {
            trace,
            iso: Iso::of(method, trace, &as_read)?,
            centred_rms_mm: rms(&measured),
            left_rms_mm: left.norm() / freedom.sqrt(),
            noise_mm: noise(samples, &left),
            left_circularity_mm: range(left_contours),
            drift: Drift::of(trace, &design, &left),
            contours,
            errors,
            together: others
                .as_deref()
                .map_or_else(|_| Vec::new(), |others| confounded_together(others, &design)),
            others,
        })
    }

    /// Causes that are not on the list and read as errors of the list, as far as they are known.
    pub fn others(&self) -> impl Iterator<Item = &Other> {
        self.others.iter().flatten()
    }

    /// Share of the variance of the centred trace that the list leaves, 0…1.
    pub fn unexplained(&self) -> f64 {
        (self.left_rms_mm / self.centred_rms_mm.max(f64::MIN_POSITIVE)).powi(2).min(1.0)
    }

    /// The list lacks something.
    pub fn leaves_more_than_noise(&self) -> bool {
        self.left_rms_mm > NOISE_AND_MORE * self.noise_mm
    }

    /// What is left beyond the noise of the readings as a circularity: the range of a sine of its rms, 2√2 of it, mm.
    pub fn unexplained_circularity_mm(&self) -> f64 {
        2.0 * std::f64::consts::SQRT_2 * self.unexplained_beyond_noise_mm()
    }

    /// A circularity as share of those of all errors and of what is unexplained, in words.
    pub fn share(&self, circularity_mm: f64) -> String {
        let errors_mm: f64 = self.errors.iter().map(|error| error.circularity_mm).sum();
        let all_mm = errors_mm + self.unexplained_circularity_mm();
        format!("{:.0} %", 100.0 * circularity_mm / all_mm.max(f64::MIN_POSITIVE))
    }

    /// What is left beyond the noise of the readings, mm rms.
    pub fn unexplained_beyond_noise_mm(&self) -> f64 {
        (self.left_rms_mm.powi(2) - self.noise_mm.powi(2)).max(0.0).sqrt()
    }
}

impl Iso {
    /// G(b), or G of the only direction.
    pub fn of_the_trace_mm(&self) -> f64 {
        self.g_b_mm.unwrap_or_else(|| self.g_mm.iter().map(|(_, g_mm)| *g_mm).fold(0.0, f64::max))
    }

    fn of(method: &Method, trace: &Trace, as_read: &[(f64, Contour)]) -> Result<Self, MethodError> {
        let r_mm = trace.radius_mm;
        let place =
            |(angle, deviation): &(f64, f64)| Vector2::new(angle.cos(), angle.sin()) * (r_mm + deviation);
        let circle = |places: Vec<Vector2<f64>>| {
            geometry::circle(&places)
                .map_err(|error| method.lacks(format!("plane {}: {error}", trace.name), ""))
        };
        let mut g_mm = Vec::new();
        for (way, contour) in as_read {
            let round = circle(contour.iter().map(place).collect())?;
            g_mm.push((*way, range(round.deviation_mm.iter().copied())));
        }
        let both = circle(as_read.iter().flat_map(|(_, contour)| contour.iter().map(place)).collect())?;
        let known = trace.calibrated;
        let d_mm = without(both.radius_mm - r_mm, ROUNDING_MM);
        let (low, high) = extent(both.deviation_mm.iter().map(|v| without(v + d_mm, ROUNDING_MM)));
        Ok(Self {
            g_b_mm: (g_mm.len() > 1).then(|| range(both.deviation_mm.iter().copied())),
            d_mm: known.then_some(d_mm),
            f_mm: known.then_some([high, low]),
            g_mm,
        })
    }
}

/// u of each column of the fit under the noise that the readings show next to all of them; by what is left and its correlation where they are too
/// few to say what is noise.
fn u_of_columns(
    readings: Option<&Experiment>,
    design: &DMatrix<f64>,
    fit: &LinearFit,
    left: &DVector<f64>,
) -> DVector<f64> {
    let noise = readings.and_then(|readings| {
        ReadingNoise::next_to(readings, design, left, &vec![true; readings.points.len()])
    });
    let shares = || design * &fit.cofactor;
    noise.map_or_else(|| &fit.u * widened(left), |noise| noise.u(&shares(), BeyondModel::NOTHING))
}

/// Deviations as if the ball sat so little off the centre that it reads as cos φ and sin φ alone.
fn of_centre(trace: &Trace, centring: &DMatrix<f64>, read: &DVector<f64>) -> DVector<f64> {
    let bars_mm: Vec<Vector3<f64>> = trace.samples.iter().map(|sample| bar_mm(trace, sample)).collect();
    to_first_order(read, &bars_mm, |deviation| {
        let centre = least_squares(centring, deviation, OFF_TOLERANCE).x;
        vec![Vector3::new(centre[1], centre[2], 0.0); bars_mm.len()]
    })
}

/// From the table's ball to the tool's in the plane.
fn bar_mm(trace: &Trace, sample: &Sample) -> Vector3<f64> {
    let (sin, cos) = sample.angle_rad.sin_cos();
    Vector3::new(cos, sin, 0.0) * trace.radius_mm
}

fn centre_row(sample: &Sample) -> [f64; CENTRING] {
    let (sin, cos) = sample.angle_rad.sin_cos();
    [1.0, cos, sin]
}

fn design(trace: &Trace, list: &[Listed], decay_mm: [f64; 2]) -> DMatrix<f64> {
    let row = |sample: &Sample| -> Vec<f64> {
        let errors = list.iter().flat_map(|item| columns(item.kind, trace, decay_mm, sample));
        centre_row(sample).into_iter().chain(errors).chain(of_beginnings(trace, decay_mm, sample)).collect()
    };
    let rows: Vec<Vec<f64>> = trace.samples.iter().map(row).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, k| rows[i][k])
}

/// The columns with that of each decay s₀: it was sought too, so that u of what resembles it, backlash and spike, holds it.
fn with_decays(trace: &Trace, list: &[Listed], decay_mm: [f64; 2], design: DMatrix<f64>) -> DMatrix<f64> {
    let first = design.ncols();
    let is_listed = |k: &usize| list.iter().any(|item| item.kind == ListedKind::ReversalSpike(*k));
    let spikes: Vec<usize> = [0, 1].into_iter().filter(is_listed).collect();
    let mut design = design.resize_horizontally(first + spikes.len(), 0.0);
    for (at, k) in spikes.into_iter().enumerate() {
        for (i, sample) in trace.samples.iter().enumerate() {
            design[(i, first + at)] = of_decay(k, decay_mm[k], sample);
        }
    }
    design
}

/// s₀ of the spikes of both axes by which the whole list leaves least: one axis after the other, twice over shares of the
/// radius, then in ever smaller steps.
fn decays(trace: &Trace, list: &[Listed], deviation: &DVector<f64>) -> [f64; 2] {
    let left = |decay_mm: [f64; 2]| {
        let design = design(trace, list, decay_mm);
        let fit = least_squares(&design, deviation, TOLERANCE);
        (deviation - design * fit.x).norm()
    };
    let spikes = [0, 1].into_iter().filter(|&k| list.iter().any(|l| l.kind == ListedKind::ReversalSpike(k)));
    let spikes: Vec<usize> = spikes.collect();
    let mut best = [0.02 * trace.radius_mm; 2];
    let least_of = |tried: &[f64], best: [f64; 2], k: usize| {
        let with = tried.iter().map(|&of_k| {
            let mut decay_mm = best;
            decay_mm[k] = of_k;
            (left(decay_mm), decay_mm)
        });
        with.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(best, |(_, decay_mm)| decay_mm)
    };
    for _ in 0..2 {
        for &k in &spikes {
            best = least_of(&DECAYS.map(|share| share * trace.radius_mm), best, k);
        }
    }
    for step in [1.2, 1.1, 1.05, 1.02] {
        for &k in &spikes {
            let longer_mm = (best[k] * step).min(LONGEST_DECAY * trace.radius_mm);
            best = least_of(&[best[k] / step, best[k], longer_mm], best, k);
        }
    }
    best
}

/// A spike whose decay was sought may be fitted to noise and then spoils the backlash: kept only where it stands out.
fn without_doubtful_spikes(
    trace: &Trace,
    list: Vec<Listed>,
    deviation: &DVector<f64>,
) -> (Vec<Listed>, [f64; 2]) {
    let mut list = list;
    loop {
        let decay_mm = decays(trace, &list, deviation);
        let design = design(trace, &list, decay_mm);
        let fit = least_squares(&design, deviation, TOLERANCE);
        let widened = widened(&(deviation - &design * &fit.x));
        let (mut first, mut weakest) = (CENTRING, None);
        for (i, item) in list.iter().enumerate() {
            let x = without(fit.x[first], rounding(design.column(first)));
            let stands_out = x.abs() / (widened * fit.u[first]).max(f64::MIN_POSITIVE);
            if matches!(item.kind, ListedKind::ReversalSpike(_))
                && stands_out < SPIKE_STANDS_OUT
                && weakest.is_none_or(|(_, least)| stands_out < least)
            {
                weakest = Some((i, stands_out));
            }
            first += columns(item.kind, trace, decay_mm, &trace.samples[0]).len();
        }
        let Some((i, _)) = weakest else { return (list, decay_mm) };
        list.remove(i);
    }
}

fn contour(stations: &Stations, samples: &[Sample], way: f64, of: &DVector<f64>) -> Contour {
    let of_way = samples.iter().zip(of.iter()).filter(|(sample, _)| sample.way == way);
    let means = stations.contour(of_way.map(|(sample, value)| (sample.angle_rad, *value)));
    means.into_iter().map(|(angle_rad, mm)| (angle_rad, without(mm, ROUNDING_MM))).collect()
}

/// Noise by second differences of neighbours in time within a way, from their median: var(l₁ − 2 l₂ + l₃) = 6 σ² (Neumann 1941), and the
/// median of |normal| is 0.6745 σ. What the list does not explain is smooth or a few steps, and moves neither.
fn noise(samples: &[Sample], left: &DVector<f64>) -> f64 {
    let of_one_way =
        |i: &usize| samples[i - 1].way == samples[*i].way && samples[*i].way == samples[i + 1].way;
    let inner = 1..samples.len().saturating_sub(1);
    let second: Vec<f64> =
        inner.filter(of_one_way).map(|i| (left[i - 1] - 2.0 * left[i] + left[i + 1]).abs()).collect();
    upper_median(&second).map_or(0.0, |median| median / (MEDIAN_OF_NORMAL * 6.0_f64.sqrt()))
}

fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = extent(values);
    without((high - low).max(0.0), ROUNDING_MM)
}
