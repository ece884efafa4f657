//! JCGM 101: distributions propagated through the whole fit, against the linear propagation of JCGM 100.

use super::experiment::{Truth, columns, exact_readings, experiment, model, options, set_readings, truth};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::fmt::Write;
use trunnion_effects::Unit;
use trunnion_engine::{Experiment, identify};

/// White noise of a reading, mm.
const SIGMA_MM: f64 = 0.3e-3;
/// Half-width of a 95 % interval of the normal distribution, in standard uncertainties.
const WIDE: f64 = 1.959964;
const THREADS: usize = 2;

/// One parameter.
pub struct Row {
    pub parameter: String,
    pub unit: Unit,
    /// Linear propagation of the known noise, inside units.
    pub u_linear: f64,
    /// Standard deviation over the trials.
    pub u_monte_carlo: f64,
    /// Mean over the trials minus the truth, in `u_linear`.
    pub bias: f64,
    /// Share of trials in which value ± 1.96 u holds the truth, u by linear propagation.
    pub held_known: f64,
    /// The same with the u of clusters of the residual of that trial, `Uncertainties::Clusters`.
    pub held_clusters: f64,
}

/// All of it.
pub struct Outcome {
    pub trials: usize,
    pub readings: usize,
    /// Parameters the fit leaves free.
    pub free: usize,
    pub rows: Vec<Row>,
}

/// Sums over trials, parameter by parameter.
#[derive(Clone)]
struct Sums {
    off: DVector<f64>,
    squares: DVector<f64>,
    held_known: DVector<f64>,
    held_clusters: DVector<f64>,
}

/// Runs `trials` fits of freshly drawn readings.
pub fn run(trials: usize) -> Outcome {
    let experiment = experiment(1);
    let truth = truth(&experiment);
    let exact = exact_readings(&experiment, &truth.solution);
    let a = columns(&experiment, &model()).select_columns(&truth.seen);
    let norms = DVector::from_iterator(a.ncols(), a.column_iter().map(|c| c.norm()));
    let mut scaled = a.clone();
    for j in 0..a.ncols() {
        scaled.column_mut(j).scale_mut(norms[j].recip());
    }
    let cofactor = (scaled.transpose() * &scaled).cholesky().expect("determined columns").inverse();
    let u = DVector::from_fn(a.ncols(), |j, _| SIGMA_MM * cofactor[(j, j)].sqrt() / norms[j]);

    let share = |thread: usize| trials / THREADS + usize::from(thread < trials % THREADS);
    let sums: Vec<Sums> = std::thread::scope(|scope| {
        let (experiment, truth, exact, u) = (&experiment, &truth, &exact, &u);
        let workers: Vec<_> = (0..THREADS)
            .map(|k| scope.spawn(move || draw(experiment.clone(), truth, exact, u, k, share(k))))
            .collect();
        workers.into_iter().map(|worker| worker.join().expect("no trial panics")).collect()
    });
    let total = sums.into_iter().reduce(Sums::plus).expect("threads");
    let fit = identify(&experiment, &model(), &options()).expect("a fit");
    let n = trials as f64;
    let rows = truth.with_number.iter().map(|&k| (k, truth.seen[k])).map(|(k, j)| Row {
        parameter: format!("{} · {}", fit.parameters[j].effect, fit.parameters[j].name),
        unit: fit.parameters[j].unit,
        u_linear: u[k],
        u_monte_carlo: ((total.squares[k] - total.off[k].powi(2) / n) / (n - 1.0)).sqrt(),
        bias: total.off[k] / n / u[k],
        held_known: total.held_known[k] / n,
        held_clusters: total.held_clusters[k] / n,
    });
    Outcome { trials, readings: experiment.rows(), free: truth.seen.len(), rows: rows.collect() }
}

fn draw(
    mut experiment: Experiment,
    truth: &Truth,
    exact: &DVector<f64>,
    u: &DVector<f64>,
    thread: usize,
    trials: usize,
) -> Sums {
    let mut rng = ChaCha8Rng::seed_from_u64(101 + thread as u64);
    let mut sums = Sums::zeros(truth.seen.len());
    for _ in 0..trials {
        let noisy = exact.map(|reading| -> f64 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            reading + SIGMA_MM * normal
        });
        set_readings(&mut experiment, noisy.as_slice());
        let fit = identify(&experiment, &model(), &options()).expect("a fit");
        for &k in &truth.with_number {
            let j = truth.seen[k];
            let off = fit.solution[j] - truth.solution[j];
            sums.off[k] += off;
            sums.squares[k] += off * off;
            sums.held_known[k] += f64::from(u8::from(off.abs() <= WIDE * u[k]));
            let stated = fit.parameters[j].u.expect("a determined parameter");
            sums.held_clusters[k] += f64::from(u8::from(off.abs() <= WIDE * stated));
        }
    }
    sums
}

impl Sums {
    fn zeros(width: usize) -> Self {
        let zeros = DVector::zeros(width);
        Self { off: zeros.clone(), squares: zeros.clone(), held_known: zeros.clone(), held_clusters: zeros }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            off: self.off + other.off,
            squares: self.squares + other.squares,
            held_known: self.held_known + other.held_known,
            held_clusters: self.held_clusters + other.held_clusters,
        }
    }
}

impl Outcome {
    /// Mean over the parameters.
    pub fn mean(&self, of: impl Fn(&Row) -> f64) -> f64 {
        self.rows.iter().map(of).sum::<f64>() / self.rows.len() as f64
    }

    /// Largest distance of a ratio u(Monte Carlo)/u(linear) from one.
    pub fn worst_ratio(&self) -> f64 {
        self.rows.iter().map(|row| (row.u_monte_carlo / row.u_linear - 1.0).abs()).fold(0.0, f64::max)
    }

    pub fn to_markdown(&self) -> String {
        let held: Vec<f64> = self.rows.iter().map(|row| row.held_known).collect();
        let (least, most) = held.iter().fold((1.0f64, 0.0f64), |(a, b), &h| (a.min(h), b.max(h)));
        let mut text = format!(
            "{}\n\n\
             JCGM 101 against JCGM 100: an R-test over 84 poses, {} readings with white noise of 0.3 µm, {} free parameters,\n\
             {} of them with a number of their own; {} trials, each through the exact prediction and the whole Gauss–Newton\n\
             fit. u by Monte Carlo is within {:.1} % of u by linear propagation for every parameter; 95 % intervals with the\n\
             linear u hold the truth in {:.4} of the trials ({:.4} to {:.4} over the parameters), with the u of clusters of that\n\
             trial's residual (a little wide by design: clusters only widen) in {:.4}. The program states the u of clusters where\n\
             readings are few; else it states the u of noise parts, whose share is in the [schemes](schemes.md#over-many-seeds).\n\n\
             | parameter | unit | u, linear | u, Monte Carlo | ratio | bias, u | held, known noise | held, clusters |\n\
             |---|---|---|---|---|---|---|---|\n",
            super::document::MONTE_CARLO,
            self.readings,
            self.free,
            self.rows.len(),
            self.trials,
            100.0 * self.worst_ratio(),
            self.mean(|row| row.held_known),
            least,
            most,
            self.mean(|row| row.held_clusters),
        );
        for row in &self.rows {
            let per_inside = row.unit.per_inside;
            writeln!(
                text,
                "| {} | {} | {:.4} | {:.4} | {:.3} | {:+.3} | {:.4} | {:.4} |",
                row.parameter,
                row.unit.symbol,
                row.u_linear * per_inside,
                row.u_monte_carlo * per_inside,
                row.u_monte_carlo / row.u_linear,
                row.bias,
                row.held_known,
                row.held_clusters,
            )
            .expect("strings take all");
        }
        text
    }
}
