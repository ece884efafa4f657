//! The factors of the open grammar: how a motion without a name may depend on angle, direction, place and time (docs/design/statistics.md §4.3).
//!
//! A family is one expression with shape numbers (where, how wide, how fast). Only a coarse grid of them is scanned for every carrier;
//! the shape numbers of what does well are then refined, and its relatives (the same idea in another form, such as the soft form of a step)
//! are tried as well.

mod angle;
mod clock;
mod draft;
mod family;
pub mod travel;

pub use family::{Carriers, Family, Number};

use crate::Experiment;
use crate::noise::machine_noise::Order;
use crate::spectrum::Wave;
use draft::Draft;
use trunnion_core::Joint;
use trunnion_effects::{Formula, Instance, ModelEffect};

/// Every family that makes sense in an experiment.
pub fn families(experiment: &Experiment, order: &Order, waves: &[(Joint, Wave)]) -> Vec<Family> {
    let rotary: Vec<Joint> = [order.slow, order.fast].into_iter().flatten().collect();
    let scene = &experiment.scene;
    let mut drafts = Vec::new();
    angle::angles(&rotary, &mut drafts);
    for &letter in &rotary {
        angle::directions(letter, &rotary, scene, &mut drafts);
        angle::places(letter, scene, &mut drafts);
        angle::knees(letter, scene, &mut drafts);
    }
    drafts.extend(waves.iter().map(|(joint, wave)| travel::wave(*joint, wave)));
    travel::linear(experiment, &mut drafts);
    travel::moving(&rotary, scene, &mut drafts);
    if let Some(duration_s) = scene.duration_s().filter(|d| *d > 0.0) {
        clock::settling(duration_s, &rotary, &mut drafts);
        clock::switching(duration_s, scene, &mut drafts);
    }
    clock::temperatures(&rotary, scene, &mut drafts);
    drafts.into_iter().filter_map(|draft| family(draft, experiment)).collect()
}

fn family(draft: Draft, experiment: &Experiment) -> Option<Family> {
    let terms = draft.columns.iter().enumerate();
    let term = |(i, factor): (usize, &String)| match factor.strip_prefix("1/") {
        Some(below) => format!("p{}/{below}", i + 1),
        None => format!("p{}*{factor}", i + 1),
    };
    let expression = terms.map(term).collect::<Vec<_>>().join(" + ");
    let entry = ModelEffect {
        id: Formula::id_of("factor"),
        site: Some("spindle".into()),
        component: Some("dx".into()),
        expression: Some(expression.clone()),
        shape: draft.grid.first().cloned().unwrap_or_default(),
        ..ModelEffect::default()
    };
    let formula = Instance::from_model_effect(&entry, experiment.machine()).unwrap_or_else(|error| {
        panic!("the grammar writes formulas that can be read: {error:?}: {expression}")
    });
    if formula.parameters(&experiment.scene).is_empty() {
        return None;
    }
    Some(Family {
        expression,
        formula,
        columns: draft.columns.len(),
        numbers: draft.numbers,
        grid: draft.grid,
        price_ln: draft.order as f64,
        words: draft.words,
        idea: draft.idea,
        carriers: draft.carriers,
        natural: draft.natural,
        scanned: draft.scanned,
    })
}
