//! Whether runs hold enough of what was planned to be judged.
//!
//! What decides is not how many points are missing but what the others still determine: of the location errors, which every
//! verdict rests on, the direction that has lost most. With J the columns of the base model at the planned states, those of ball
//! and nest projected out, the information of a direction w is wᵀJᵀJw; the points that were read keep a share of it, the least
//! of which is the least eigenvalue of JᵣᵀJᵣ in the metric of JᵀJ.
//! The states are the nominal ones: what the controller recorded scatters about them and would show directions that the cycle
//! does not. Runs without a cycle (imports) plan what they hold.

mod passes;

use nalgebra::DMatrix;
use passes::Passes;
use trunnion_core::{Point, Quality, State};
use trunnion_cycles::cycle::Motion;
use trunnion_cycles::{Cycle, Pace, Run};
use trunnion_effects::Model;
use trunnion_effects::catalogue::LOCATION_ERRORS;
use trunnion_machine::Machine;
use trunnion_record::RunHeader;
use trunnion_results::{Complete, Excluded, Missing, Plausibility, Question};

/// With less of the planned information a value is more than twice as uncertain as planned: u goes with its inverse root. To
/// make up for it takes four times the cycle, which is another measurement than the one that was asked for.
const LEAST_KEPT: f64 = 0.25;
/// Planned states looked at, evenly over the cycle: more change no share.
const MOST_STATES: usize = 600;
/// A direction with less of the information of the strongest is not determined by the plan itself.
const DETERMINED: f64 = 1e-9;
/// More stretches of missing points than this are not listed.
const MOST_RANGES: usize = 8;

/// What became of a planned point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Missing,
    Unsettled,
    Read,
}

/// What a recording should hold, and what became of it.
pub struct Planned {
    cycle: Cycle,
    states: Vec<State>,
    fates: Vec<Fate>,
    /// Points of the files before this one, and of those read so far.
    before: u64,
    taken: u64,
    /// On the fly: how samples find their planned states.
    passes: Option<Passes>,
}

impl Planned {
    /// From the cycle in a recording; `None` when it holds none that this machine can run.
    pub(crate) fn of(header: &RunHeader, machine: &Machine) -> Option<Self> {
        let cycle = Cycle::parse("recorded cycle", &header.cycle_text).ok()?;
        let states = match &cycle.motion {
            Motion::Static { .. } | Motion::Line { .. } => {
                let state = |pose: trunnion_cycles::cycle::Pose| State {
                    position: pose.position,
                    direction: pose.direction,
                    setup: pose.setup,
                    target: pose.target,
                    ..State::default()
                };
                cycle.poses(machine)?.into_iter().map(state).collect()
            }
            Motion::OnTheFly { .. } | Motion::Path { .. } => {
                cycle.visits(machine, &Pace::default()).ok()?.states
            }
        };
        // Where the header contradicts its own cycle nobody knows what was planned.
        if states.iter().any(|state| state.setup >= header.setups.len()) {
            return None;
        }
        let passes = Passes::of(&cycle, machine, &states);
        Some(Self { cycle, fates: vec![Fate::Missing; states.len()], states, before: 0, taken: 0, passes })
    }

    /// The next file of the run follows: its points are numbered from zero again.
    pub(crate) fn next_part(mut self) -> Self {
        self.before = self.taken;
        self
    }

    /// The next point of the recording, with its number.
    pub(crate) fn take(&mut self, index: u64, point: &Point) {
        let index = self.before + index;
        self.taken = self.taken.max(index + 1);
        let fate = match point.quality {
            Quality::Good if point.reading_mm.iter().all(|mm| mm.is_finite()) => Fate::Read,
            Quality::Good | Quality::NoReading(_) => Fate::Missing,
            Quality::Unsettled => Fate::Unsettled,
        };
        let at = match &mut self.passes {
            Some(passes) => passes.find(point),
            None => usize::try_from(index).into_iter().collect(),
        };
        for k in at {
            if let Some(slot) = self.fates.get_mut(k) {
                *slot = fate;
            }
        }
    }

    fn count(&self, fate: Fate) -> usize {
        self.fates.iter().filter(|one| **one == fate).count()
    }

    /// Points without a reading, setup by setup.
    fn missing(&self, run: &str) -> Vec<Missing> {
        let of_setup = |(setup, name): (usize, &String)| {
            let mine = |k: &usize| self.states[*k].setup == setup;
            let planned = (0..self.states.len()).filter(mine).count();
            let missing: Vec<usize> =
                (0..self.states.len()).filter(mine).filter(|&k| self.fates[k] == Fate::Missing).collect();
            let (count, points) = (missing.len(), ranges(&missing));
            (count > 0).then(|| Missing { run: run.into(), setup: name.clone(), count, planned, points })
        };
        let names: Vec<String> = self.cycle.setups.iter().map(|setup| setup.name.clone()).collect();
        names.iter().enumerate().filter_map(of_setup).collect()
    }
}

/// What the runs hold of what was planned, each as read with its plan, and why that is too little to be judged.
pub(crate) fn complete(runs: &[Run], plans: &[Option<Planned>]) -> (Complete, Option<Plausibility>) {
    let mut complete = Complete::default();
    let mut unsettled = 0;
    for (run, plan) in runs.iter().zip(plans) {
        match plan {
            Some(plan) => {
                *complete.planned.get_or_insert(0) += plan.states.len();
                complete.read += plan.count(Fate::Read);
                complete.missing.extend(plan.missing(&run.name));
                unsettled += plan.count(Fate::Unsettled);
            }
            None => {
                let good = run.good_points().count();
                if let Some(planned) = &mut complete.planned {
                    *planned += run.points.len();
                }
                complete.read += good;
                unsettled += run.points.iter().filter(|point| point.quality == Quality::Unsettled).count();
            }
        }
    }
    if unsettled > 0 {
        complete.excluded.push(Excluded { reason: "the reading never settled".into(), count: unsettled });
    }
    let kept = if plans.iter().flatten().all(|plan| plan.count(Fate::Read) == plan.states.len()) {
        None
    } else {
        kept(runs, plans)
    };
    let too_little = kept.filter(|kept| *kept < LEAST_KEPT).map(|kept| not_whole(&complete, kept));
    (complete, too_little)
}

fn not_whole(complete: &Complete, kept: f64) -> Plausibility {
    let planned = complete.planned.unwrap_or(0);
    let worse = match kept.max(0.0).sqrt().recip() {
        times if times < 1e3 => format!("determine a location error {times:.1} times less well than planned"),
        _ => "leave a location error undetermined that the cycle was to determine".into(),
    };
    let setups: Vec<String> =
        complete.missing.iter().map(|part| format!("{} ({})", part.setup, part.points)).collect();
    let again = match setups.is_empty() {
        true => "Repeat the cycle.".into(),
        false => format!(
            "Repeat the cycle, or at least these points, and give both runs together: {}.",
            setups.join("; ")
        ),
    };
    Plausibility {
        question: Question::Whole,
        finding: format!("{} of {planned} planned points were read; they {worse}.", complete.read),
        hypothesis: again,
        rms_um_with_it: None,
    }
}

/// Least share of the planned information about any direction of the location errors; `None` where nothing was planned about them.
fn kept(runs: &[Run], plans: &[Option<Planned>]) -> Option<f64> {
    let mut read = Vec::new();
    let total: usize = runs.iter().zip(plans).map(|(run, plan)| planned_states(run, plan).len()).sum();
    let every = total.div_ceil(MOST_STATES).max(1);
    let imagined: Vec<Run> = runs
        .iter()
        .zip(plans)
        .map(|(run, plan)| {
            let states = planned_states(run, plan);
            let chosen = (0..states.len()).step_by(every);
            let is_read = |k: usize| plan.as_ref().is_none_or(|plan| plan.fates[k] == Fate::Read);
            read.extend(chosen.clone().map(is_read));
            let point = |k: usize| Point {
                state: states[k].clone(),
                reading_mm: [0.0; 3],
                spread_mm: [0.0; 3],
                samples: 0,
                quality: Quality::Good,
            };
            Run { channels: Vec::new(), points: chosen.map(point).collect(), ..run.clone() }
        })
        .collect();
    let experiment = trunnion_engine::Experiment::of_points(&imagined).ok()?;
    let columns_of = |id: &str| {
        let instance = trunnion_effects::Instance::find(id, experiment.machine()).ok()?;
        Some(experiment.columns(&instance, &[]))
    };
    let model = Model::base(&experiment.machine().name);
    let mut location = columns_of(LOCATION_ERRORS).filter(|columns| columns.ncols() > 0)?;
    // Columns of rad and of mm on one scale, before anything is projected out of them.
    for mut column in location.column_iter_mut() {
        let norm = column.norm();
        column.scale_mut(if norm > 0.0 { norm.recip() } else { 0.0 });
    }
    let others: Vec<DMatrix<f64>> = model
        .effects
        .iter()
        .filter(|entry| entry.id != LOCATION_ERRORS)
        .filter_map(|entry| columns_of(&entry.id))
        .collect();
    let rows: Vec<usize> = (0..read.len()).filter(|&k| read[k]).flat_map(|k| experiment.rows_of(k)).collect();
    let all: Vec<usize> = (0..experiment.rows()).collect();
    least_share(&information(&location, &others, &all), &information(&location, &others, &rows))
}

/// The states that a run was to read; without a cycle, those that it read.
fn planned_states(run: &Run, plan: &Option<Planned>) -> Vec<State> {
    match plan {
        Some(plan) => plan.states.clone(),
        None => run.good_points().map(|point| point.state.clone()).collect(),
    }
}

/// Indices counted from 1, neighbours together: `3, 11 to 72`.
fn ranges(indices: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for &k in indices {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == k => *last = k,
            _ => parts.push((k, k)),
        }
    }
    let shown = parts.iter().take(MOST_RANGES).map(|(first, last)| match last - first {
        0 => (first + 1).to_string(),
        _ => format!("{} to {}", first + 1, last + 1),
    });
    let more = (parts.len() > MOST_RANGES).then(|| "…".to_string());
    shown.chain(more).collect::<Vec<_>>().join(", ")
}

/// JᵀJ of columns in some rows, others projected out.
fn information(columns: &DMatrix<f64>, others: &[DMatrix<f64>], rows: &[usize]) -> DMatrix<f64> {
    let mut left = columns.select_rows(rows);
    if rows.is_empty() {
        return DMatrix::zeros(columns.ncols(), columns.ncols());
    }
    let width = others.iter().map(DMatrix::ncols).sum();
    let mut joined = DMatrix::zeros(rows.len(), width);
    let mut first = 0;
    for other in others {
        joined.columns_mut(first, other.ncols()).copy_from(&other.select_rows(rows));
        first += other.ncols();
    }
    let (values, basis) = eigen(joined.tr_mul(&joined));
    let largest = values.iter().copied().fold(0.0, f64::max);
    for (k, value) in values.iter().enumerate().filter(|(_, value)| **value > DETERMINED * largest) {
        let direction = &joined * basis.column(k) / value.sqrt();
        let along = direction.tr_mul(&left);
        left -= direction * along;
    }
    left.tr_mul(&left)
}

/// Least eigenvalue of `read` in the metric of `planned`, on what the plan determines.
fn least_share(planned: &DMatrix<f64>, read: &DMatrix<f64>) -> Option<f64> {
    let (values, basis) = eigen(planned.clone());
    let largest = values.iter().copied().fold(0.0, f64::max);
    let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > DETERMINED * largest).collect();
    if kept.is_empty() {
        return None;
    }
    let whitened =
        DMatrix::from_fn(planned.nrows(), kept.len(), |i, k| basis[(i, kept[k])] / values[kept[k]].sqrt());
    let share = whitened.transpose() * read * whitened;
    Some(eigen(share).0.into_iter().fold(f64::INFINITY, f64::min))
}

fn eigen(symmetric: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let decomposed = symmetric.symmetric_eigen();
    (decomposed.eigenvalues.iter().copied().collect(), decomposed.eigenvectors)
}
