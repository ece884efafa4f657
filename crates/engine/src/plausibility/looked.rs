//! A run as the rules of readings and positions look at it: some of its points, without those that no fit keeps.
//!
//! A single wrong reading is left out of every fit and listed there; here it would speak for a mistake in all of them, such as readings
//! that are one row late where it is the first.

use super::fitted::{Fitted, columns};
use crate::Experiment;
use crate::fit::identification::Repeatability;
use crate::noise::outliers::excluded;
use crate::noise::repeatability::repeatability;
use crate::problem::passes::passes;
use nalgebra::DVector;
use std::cell::OnceCell;
use std::convert::Infallible;
use trunnion_core::{InstrumentKind, Point};
use trunnion_cycles::Run;

/// Longer runs are reduced to so many points, for time only.
pub(super) const MOST_POINTS: usize = 1_500;
/// Neighbours that stay together: a reading that belongs to the row before is still next to it.
const STRETCH: usize = 100;

/// More of them are no single ones: a mistake in all readings leaves some farther off than the rest.
const MOST_WRONG: f64 = 0.01;

/// Good points of a run with the base model fitted to them.
pub(super) struct Looked<'a> {
    /// All of it.
    pub whole: &'a Run,
    pub run: Run,
    /// Which of them were kept of those that were looked at: of all good points where these are no more than [`MOST_POINTS`].
    pub kept: Vec<bool>,
    /// Setup of each of those that were looked at.
    pub setup: Vec<usize>,
    pub experiment: Experiment,
    pub model: Fitted,
    /// What the base model leaves of the readings as they are, rms, mm.
    pub left_mm: f64,
    repeated: OnceCell<Option<Repeatability>>,
}

impl<'a> Looked<'a> {
    /// `None` where the run has no base model or no points, and of distances from a station, which is set anywhere: they hold the
    /// way to it, which no base model takes off.
    pub fn at(run: &'a Run) -> Option<Self> {
        if run.setups.iter().any(|setup| setup.instrument == InstrumentKind::Tracker) {
            return None;
        }
        let whole = Experiment::of_points(&[with_points(run, thinned(run))]).ok()?;
        let columns = columns(&whole)?;
        let readings_mm = whole.readings_mm();
        let fit = |used: &[bool]| -> Result<DVector<f64>, Infallible> {
            let of_row: Vec<bool> =
                (0..used.len()).flat_map(|i| whole.rows_of(i).map(move |_| used[i])).collect();
            Ok(Fitted::on(&columns, |row| of_row[row]).left_mm(&readings_mm))
        };
        let Ok((mut kept, _)) = excluded(&whole, fit, |left_mm| left_mm);
        let wrong = kept.iter().filter(|kept| !**kept).count();
        if wrong as f64 > MOST_WRONG * kept.len() as f64 {
            kept.fill(true);
        }
        let setup = whole.points.iter().map(|point| point.state.setup).collect();
        let experiment = whole.kept(&kept);
        let looked_at = with_points(run, experiment.points.iter().collect());
        let model = Fitted::new(&experiment)?;
        let left_mm = model.rms_mm(&experiment.readings_mm());
        Some(Self {
            whole: run,
            run: looked_at,
            kept,
            setup,
            experiment,
            model,
            left_mm,
            repeated: OnceCell::new(),
        })
    }

    /// How well the readings repeat; worked out once, for all rules that ask.
    pub fn repeated(&self) -> Option<Repeatability> {
        *self.repeated.get_or_init(|| repeatability(&self.experiment, &passes(&self.experiment)))
    }
}

/// Some [`MOST_POINTS`] good points: stretches of neighbours, evenly from the beginning to the end.
pub(super) fn thinned(run: &Run) -> Vec<&Point> {
    let good: Vec<&Point> = run.good_points().collect();
    let every = good.len().div_ceil(MOST_POINTS).max(1);
    let chosen = good.into_iter().enumerate().filter(|(k, _)| (k / STRETCH).is_multiple_of(every));
    chosen.map(|(_, point)| point).collect()
}

/// The run with some of its points. Field by field: a clone of the run would copy a million points to throw them away.
pub(super) fn with_points(run: &Run, points: Vec<&Point>) -> Run {
    Run {
        name: run.name.clone(),
        machine: run.machine.clone(),
        kind: run.kind,
        setups: run.setups.clone(),
        channels: run.channels.clone(),
        points: points.into_iter().cloned().collect(),
    }
}
