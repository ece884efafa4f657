//! A trial as columns and readings, for methods that know neither machine nor noise: the base model projected out of both.

use crate::stage::Stage;
use crate::trial::Staged;
use nalgebra::{DMatrix, DVector};
use trunnion_effects::{Instance, Model, Role, catalogue};
use trunnion_engine::fit::Options;
use trunnion_engine::{HeldOut, Uncertainties, identify};
use trunnion_tests::baselines::Library;

/// Columns of which the base model leaves less than this share of the norm are not visible on this grid.
const VISIBLE: f64 = 0.03;

/// Readings without outliers and without what the base model says of them, mm.
pub fn readings(stage: &Stage, staged: &Staged) -> anyhow::Result<DVector<f64>> {
    let base = Model::base(&stage.machine.name);
    let values =
        Options { holdout: HeldOut::Skipped, uncertainties: Uncertainties::Clusters, ..Options::default() };
    let fit = identify(&staged.experiment, &base, &values)?;
    let mut readings = fit.residual_mm;
    for i in (0..fit.used.len()).filter(|&i| !fit.used[i]) {
        staged.experiment.rows_of(i).for_each(|row| readings[row] = 0.0);
    }
    Ok(stage.trial.surviving(&readings))
}

/// Columns of every effect of the catalogue at every shape of its grid that the grid can see, mm per unit: those that the diagnosis may
/// propose.
pub fn library(stage: &Stage, staged: &Staged) -> Library {
    let experiment = &staged.experiment;
    let (mut blocks, mut of) = (Vec::new(), Vec::new());
    for instance in Instance::all(&stage.machine) {
        let id = instance.id();
        let proposed =
            !matches!(instance.role(), Role::Description) && !catalogue::BASE.contains(&id.as_str());
        if !proposed || instance.parameters(&experiment.scene).is_empty() {
            continue;
        }
        for shape in instance.shapes(&experiment.scene).grid {
            let block = experiment.columns(&instance, &shape);
            of.extend(std::iter::repeat_n((id.clone(), blocks.len()), block.ncols()));
            blocks.push(block);
        }
    }
    let all: Vec<_> = blocks.iter().flat_map(|block| block.column_iter()).collect();
    let all = DMatrix::from_columns(&all);
    let surviving = stage.trial.surviving_columns(&all);
    let seen: Vec<usize> =
        (0..all.ncols()).filter(|&j| surviving.column(j).norm() > VISIBLE * all.column(j).norm()).collect();
    let mut block_of: Vec<usize> = seen.iter().map(|&j| of[j].1).collect();
    let mut blocks = block_of.clone();
    blocks.dedup();
    block_of.iter_mut().for_each(|block| *block = blocks.partition_point(|other| other < block));
    Library {
        columns: surviving.select_columns(&seen),
        effect_of: seen.iter().map(|&j| of[j].0.clone()).collect(),
        block_of,
    }
}
