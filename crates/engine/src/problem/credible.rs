//! Columns of one effect, without what is only round-off.

use crate::Experiment;
use nalgebra::DMatrix;
use trunnion_effects::{Instance, Unit};
use trunnion_instruments::Projector;

/// Less than this at a thousand times the typical size is nothing, mm rms.
const NOTHING_MM: f64 = 1e-5;

/// Points that are seen once for all columns: no run that was read from a file has more (docs/design/numerics.md §1.4). A view takes some kB.
const MOST_SEEN: usize = 10_000;

/// Columns of an effect, rows × parameters; none where the scene cannot have it, zero where one moves nothing at any credible size
/// or is not finite.
pub fn credible_columns(experiment: &Experiment, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
    credible(experiment, instance, || experiment.columns(instance, shape))
}

/// The points of an experiment, seen once for all columns that are asked for.
pub struct Seen<'a> {
    experiment: &'a Experiment,
    /// `None` of more points than are worth the memory.
    projectors: Option<Vec<Projector<'a>>>,
}

impl<'a> Seen<'a> {
    pub fn new(experiment: &'a Experiment) -> Self {
        let is_small = experiment.points.len() <= MOST_SEEN;
        Self { experiment, projectors: is_small.then(|| experiment.projectors()) }
    }

    /// [`credible_columns`].
    pub fn credible_columns(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        let experiment = self.experiment;
        credible(experiment, instance, || match &self.projectors {
            Some(projectors) => experiment.columns_seen(projectors, instance, shape),
            None => experiment.columns(instance, shape),
        })
    }
}

fn credible(
    experiment: &Experiment,
    instance: &Instance,
    columns: impl FnOnce() -> DMatrix<f64>,
) -> DMatrix<f64> {
    let parameters = instance.parameters(&experiment.scene);
    if parameters.is_empty() {
        return DMatrix::zeros(experiment.rows(), 0);
    }
    let mut columns = columns();
    let root_rows = (experiment.rows() as f64).sqrt();
    for (mut column, parameter) in columns.column_iter_mut().zip(&parameters) {
        let incredible = 1e3 * typical_size(parameter.unit);
        let norm = column.norm();
        if !norm.is_finite() || norm / root_rows * incredible < NOTHING_MM {
            column.fill(0.0);
        }
    }
    columns
}

/// What is usual of a parameter, in inside units; only the order of magnitude matters.
pub fn typical_size(unit: Unit) -> f64 {
    let on_screen = match unit.symbol {
        "um" => 3.0,
        "urad" => 15.0,
        "um/m" => 15.0,
        "um/K" => 1.0,
        "ms" => 0.3,
        "um/(m/s2)" => 3.0,
        "urad/(m/s2)" => 15.0,
        "urad/(rad/s2)" => 15.0,
        "um/(rad/s)2" => 3.0,
        "um/mm" => 0.01,
        // 1 µm at the ends of a range of ±1 mm.
        "um/mm2" => 1.0,
        _ => 0.01,
    };
    on_screen / unit.per_inside.abs()
}
