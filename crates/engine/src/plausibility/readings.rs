//! Do the readings belong to the positions? The base model, with every location error and setting free, is fitted to the
//! readings as they are and with each mistake undone.

use super::found::Implausible;
use crate::Experiment;
use crate::problem::poses::same_pose;
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{NestSide, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, Model};

/// A mistake is believed where undoing it divides what the model leaves by this: mean square by nine, which no effect that
/// resembles the mistake reaches by chance where dozens of readings are left.
const BELIEVED: f64 = 3.0;
/// Below this nothing is gross, µm rms.
const GROSS_UM: f64 = 2.0;
/// Readings of one pose scatter by at least this share of the scatter of all poses: they do not depend on the pose. Of noise alone the
/// share is 1 with the standard deviation 1/√(2f) of f repeats [Neumann 1941]: this is two of them below at 32 repeats, so that
/// fewer are doubted a little too seldom.
const NO_STRUCTURE: f64 = 0.75;
/// Fewer points say nothing.
pub(super) const FEWEST_POINTS: usize = 12;
/// Longer runs are reduced to so many points, for time only.
const MOST_POINTS: usize = 1_500;
/// Neighbours that stay together: a reading that belongs to the row before is still next to it.
const STRETCH: usize = 100;
/// Relative singular value of a direction that the columns do not see.
const UNSEEN: f64 = 1e-6;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let small: Vec<Run> = runs.iter().map(thinned).collect();
    let enough = || small.iter().filter(|run| run.points.len() >= FEWEST_POINTS);
    let found: Vec<Implausible> = enough().filter_map(nothing_but_scatter).collect();
    if found.is_empty() { enough().filter_map(exchanged).collect() } else { found }
}

/// The run with some [`MOST_POINTS`] points: stretches of neighbours, evenly from its beginning to its end.
fn thinned(run: &Run) -> Run {
    let good: Vec<&Point> = run.good_points().collect();
    let every = good.len().div_ceil(MOST_POINTS).max(1);
    let chosen = good.iter().enumerate().filter(|(k, _)| (k / STRETCH).is_multiple_of(every));
    // Field by field: a clone of the run would copy a million points to throw them away.
    Run {
        name: run.name.clone(),
        machine: run.machine.clone(),
        kind: run.kind,
        setups: run.setups.clone(),
        channels: run.channels.clone(),
        points: chosen.map(|(_, point)| (*point).clone()).collect(),
    }
}

/// Components of an R-test or bar, as they stand in a points file.
fn names(run: &Run) -> Vec<&'static str> {
    run.setups.first().map_or_else(Vec::new, |setup| setup.instrument.components().to_vec())
}

/// Readings that depend neither on the pose nor on those before: backlash differs at one pose, and so does drift, but not from one
/// reading to the next.
fn nothing_but_scatter(run: &Run) -> Option<Implausible> {
    let first = run.setups.first()?.instrument;
    if !first.deflects_probes() || run.setups.iter().any(|setup| setup.instrument != first) {
        return None;
    }
    let components = first.components().len();
    let joints = run.machine.joints();
    let setup = run.points.iter().map(|point| point.state.setup).collect();
    let positions: Vec<_> = run.points.iter().map(|point| &point.state.position).collect();
    let mut poses: HashMap<usize, Vec<&Point>> = HashMap::new();
    for (pose, point) in same_pose(setup, &positions, &joints).into_iter().zip(&run.points) {
        poses.entry(pose).or_default().push(point);
    }
    let (mut within, mut freedom, mut all, mut of_all) = (0.0, 0.0, 0.0, 0.0);
    let add = |points: &[&Point], sum: &mut f64, count: &mut f64| {
        for k in 0..components {
            let mean = points.iter().map(|point| point.reading_mm[k]).sum::<f64>() / points.len() as f64;
            *sum += points.iter().map(|point| (point.reading_mm[k] - mean).powi(2)).sum::<f64>();
        }
        *count += ((points.len() - 1) * components) as f64;
    };
    for points in poses.values() {
        add(points, &mut within, &mut freedom);
    }
    for setup in 0..run.setups.len() {
        let own: Vec<&Point> = run.points.iter().filter(|point| point.state.setup == setup).collect();
        if !own.is_empty() {
            add(&own, &mut all, &mut of_all);
        }
    }
    if freedom < FEWEST_POINTS as f64 {
        return None;
    }
    let (within_um, all_um) = (um_from_mm((within / freedom).sqrt()), um_from_mm((all / of_all).sqrt()));
    let is_nothing_else = |scatter_um: f64| scatter_um > GROSS_UM && scatter_um > NO_STRUCTURE * all_um;
    let is_scatter = is_nothing_else(within_um) && is_nothing_else(from_next_um(run, components));
    is_scatter.then(|| Implausible {
        finding: format!(
            "{}: readings of one pose scatter by {within_um:.1} µm, nothing but noise next to the {all_um:.1} µm of all poses.",
            run.name
        ),
        hypothesis: "The readings do not depend on the pose. Check that ball, nest and probes are firm, and the file.".into(),
        rms_um_with_it: None,
    })
}

/// Mistakes between readings and positions, each tried.
fn exchanged(run: &Run) -> Option<Implausible> {
    let experiment = Experiment::of_points(&[run]).ok()?;
    let model = Fitted::new(&experiment)?;
    let readings = experiment.readings_mm();
    let before_um = um_from_mm(model.rms_mm(&readings));
    if before_um < GROSS_UM {
        return None;
    }
    let names = names(run);
    let mut tried: Vec<(String, f64)> = Vec::new();
    let changed = |change: &dyn Fn(&mut [f64; 3])| {
        let mut own = experiment.clone();
        own.points.iter_mut().for_each(|point| change(&mut point.reading_mm));
        model.rms_mm(&own.readings_mm())
    };
    if names.len() == 3 {
        for (k, name) in names.iter().enumerate() {
            let flipped = changed(&|reading| reading[k] = -reading[k]);
            tried.push((format!("the sign of the readings d{name} reversed"), flipped));
            for (l, other) in names.iter().enumerate().skip(k + 1) {
                let swapped = changed(&|reading| reading.swap(k, l));
                tried.push((format!("the readings d{name} and d{other} exchanged (probe inputs)"), swapped));
            }
        }
    }
    if run.kind == RunKind::Static {
        for (earlier, words) in [
            (true, "one row earlier: they are one pose late"),
            (false, "one row later: they are one pose early"),
        ] {
            let mut own = experiment.clone();
            let count = own.points.len();
            for k in 0..count - 1 {
                let (to, from) = if earlier { (k, k + 1) } else { (k + 1, k) };
                own.points[to].reading_mm = experiment.points[from].reading_mm;
            }
            tried.push((format!("the readings shifted {words}"), model.rms_mm(&own.readings_mm())));
        }
    }
    if names.len() == 3 {
        let mut other = run.clone();
        for setup in &mut other.setups {
            setup.nest = if setup.nest == NestSide::Table { NestSide::Spindle } else { NestSide::Table };
        }
        let side = if other.setups[0].nest == NestSide::Table { "on the table" } else { "at the spindle" };
        let rms_mm = Experiment::of_points(&[other])
            .ok()
            .and_then(|other| Some(Fitted::new(&other)?.rms_mm(&readings)));
        tried.extend(rms_mm.map(|rms_mm| (format!("the nest {side}, not on the other side"), rms_mm)));
    }
    let (mistake, left_mm) = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let left_um = um_from_mm(left_mm);
    (BELIEVED * left_um < before_um).then(|| Implausible {
        finding: format!(
            "{}: the readings do not fit their positions: {before_um:.1} µm rms are left.",
            run.name
        ),
        hypothesis: format!("With {mistake}, {left_um:.1} µm are left. Change it?"),
        rms_um_with_it: Some(left_um),
    })
}

/// Directions that the base model can explain.
struct Fitted {
    basis: DMatrix<f64>,
}

impl Fitted {
    fn new(experiment: &Experiment) -> Option<Self> {
        let machine = experiment.machine();
        let model = Model::base(&machine.name);
        let mut columns = DMatrix::zeros(experiment.rows(), 0);
        for entry in &model.effects {
            let instance = Instance::from_model_effect(entry, machine).ok()?;
            let own = experiment.columns(&instance, &[]);
            let at = columns.ncols();
            columns = columns.insert_columns(at, own.ncols(), 0.0);
            columns.columns_mut(at, own.ncols()).copy_from(&own);
        }
        let seen = Reduced::from_design(&columns).orthonormal(UNSEEN);
        Some(Self { basis: columns * seen })
    }

    /// What it leaves of readings, mm rms.
    fn rms_mm(&self, readings_mm: &DVector<f64>) -> f64 {
        let left = readings_mm - &self.basis * self.basis.tr_mul(readings_mm);
        (left.norm_squared() / readings_mm.len().max(1) as f64).sqrt()
    }
}

/// Scatter from one reading to the next of a setup, root mean square of the differences / √2 [Neumann 1941], µm.
fn from_next_um(run: &Run, components: usize) -> f64 {
    let pairs = run.points.windows(2).filter(|pair| pair[0].state.setup == pair[1].state.setup);
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), pair| {
        let square = |k: usize| (pair[1].reading_mm[k] - pair[0].reading_mm[k]).powi(2);
        (sum + (0..components).map(square).sum::<f64>(), count + components as f64)
    });
    if count > 0.0 { um_from_mm((0.5 * sum / count).sqrt()) } else { 0.0 }
}
