//! What a cycle cannot show and cannot separate, computed from its poses alone, before anything is measured.
//!
//! White noise, base model. Effects whose columns coincide after the model is projected out (canonical correlation above
//! 0.999) are aliases; for each pair the cheapest candidate cycle that breaks them.

use super::candidates::candidates;
use super::consideration::{thinned, within_feeds};
use super::information::{Information, Part, View, finite};
use super::options::{Options, PlanError};
use crate::Experiment;
use nalgebra::DMatrix;
use trunnion_core::{Point, Quality, Setup, State};
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_effects::{Instance, Model, Unit};
use trunnion_machine::Machine;

/// Columns whose canonical correlation exceeds this coincide.
const ALIAS: f64 = 0.999;
/// Shapes of a continuous shape number that are looked at.
const FEW_SHAPES: usize = 3;

/// What a cycle cannot show.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// Name of the cycle.
    pub cycle: String,
    /// Points it reads.
    pub points: usize,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// Effects it shows.
    pub visible: Vec<String>,
    /// Effects that the base model imitates in it, with what would show them.
    pub invisible: Vec<(String, String)>,
    /// Effects it cannot have at all, with what they need.
    pub out_of_reach: Vec<(String, String)>,
    /// Effects that coincide in it.
    pub aliases: Vec<Alias>,
}

/// Two effects that coincide.
#[derive(Clone, Debug, PartialEq)]
pub struct Alias {
    /// The one, with its shape where it has one.
    pub one: String,
    /// The other.
    pub other: String,
    /// Directions of the smaller one that the other imitates exactly.
    pub shared: usize,
    /// Directions that each can show.
    pub directions: [usize; 2],
    /// The cheapest cycle considered that separates them, with its minutes; `None` when none does.
    pub separated_by: Option<(String, f64)>,
    /// What is known to separate them, from the catalogue.
    pub advice: String,
}

/// Looks at a cycle before it is run.
///
/// # Errors
/// A cycle the machine cannot run.
pub fn preview(machine: &Machine, cycle: &Cycle, options: &Options) -> Result<Preview, PlanError> {
    let visits = cycle.visits(machine, &options.pace)?;
    let points = visits.states.len();
    let states = thinned(visits.states, options.most_points);
    let experiment = imagined(machine, &cycle.setups, &states, cycle.run_kind())?;
    let scene = &experiment.scene;
    let all: Vec<Instance> =
        Instance::all(machine).into_iter().filter(|instance| !instance.is_base()).collect();
    let reachable = |i: &&Instance| !i.parameters(scene).is_empty() && !i.shapes(scene).grid.is_empty();
    let advice = |i: &Instance| i.about().map_or_else(String::new, |about| about.seen_by.to_string());
    let out_of_reach = all
        .iter()
        .filter(|i| !reachable(i))
        .map(|i| (i.id(), i.out_of_reach(scene).unwrap_or_default()))
        .collect();
    let parts: Vec<Part<'_>> =
        all.iter().filter(reachable).flat_map(|i| few_shapes(i, &experiment)).collect();
    let information = white(&experiment, &parts);
    let view = &information.views[0];
    let surviving: Vec<usize> =
        information.parts.iter().map(|range| view.inverse_root(range).ncols()).collect();
    let shows =
        |i: &Instance| (0..parts.len()).any(|p| std::ptr::eq(parts[p].instance, i) && surviving[p] > 0);
    let visible = all.iter().filter(reachable).filter(|i| shows(i)).map(Instance::id).collect();
    let invisible = all.iter().filter(reachable).filter(|i| !shows(i)).map(|i| (i.id(), advice(i))).collect();
    let pairs = coinciding(&parts, &information, view, &surviving);
    let separated = breakers(machine, cycle, &states, &parts, &pairs, options)?;
    let alias = |(pair, separated_by): (&Pair, Option<(String, f64)>)| Alias {
        one: label(&parts[pair.one], &experiment),
        other: label(&parts[pair.other], &experiment),
        shared: pair.shared,
        directions: [surviving[pair.one], surviving[pair.other]],
        separated_by,
        advice: advice(parts[pair.one].instance),
    };
    Ok(Preview {
        cycle: cycle.name.clone(),
        points,
        minutes: visits.duration_s / 60.0,
        visible,
        invisible,
        out_of_reach,
        aliases: pairs.iter().zip(separated).map(alias).collect(),
    })
}

struct Pair {
    one: usize,
    other: usize,
    shared: usize,
}

/// An experiment with these states and no readings.
fn imagined(
    machine: &Machine,
    setups: &[Setup],
    states: &[State],
    kind: RunKind,
) -> Result<Experiment, PlanError> {
    let point = |state: &State| Point {
        state: state.clone(),
        reading_mm: [0.0; 3],
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    };
    let run = Run {
        name: "next".into(),
        machine: machine.clone(),
        kind,
        setups: setups.into(),
        channels: Vec::new(),
        points: states.iter().map(point).collect(),
    };
    Ok(Experiment::new(&[run])?)
}

/// The shapes looked at: all counts (teeth, lobes), aliases included, a few time constants.
fn few_shapes<'a>(instance: &'a Instance, experiment: &Experiment) -> Vec<Part<'a>> {
    // What a fit would not try, because these poses show it as something else, is what has to be separated.
    let shapes = instance.shapes(&experiment.scene);
    let continuous = shapes.continuous;
    let possible = shapes.possible();
    let most = if continuous { FEW_SHAPES } else { possible.len() };
    let stride = possible.len().div_ceil(most.max(1)).max(1);
    let kept = possible.into_iter().skip(stride / 2).step_by(stride);
    kept.map(|shape| Part { instance, shape }).collect()
}

fn white(experiment: &Experiment, parts: &[Part<'_>]) -> Information {
    let base = Model::base(&experiment.machine().name);
    let columns: Vec<DMatrix<f64>> = base
        .effects
        .iter()
        .filter_map(|entry| Instance::from_model_effect(entry, experiment.machine()).ok())
        .map(|instance| finite(experiment.columns(&instance, &[])))
        .collect();
    let all: Vec<_> = columns.iter().flat_map(DMatrix::column_iter).map(|c| c.into_owned()).collect();
    Information::new(experiment, &DMatrix::from_columns(&all), parts, None)
}

/// Pairs of effects of which at least one direction coincides; the closest pair of shapes of each two effects.
fn coinciding(parts: &[Part<'_>], information: &Information, view: &View, surviving: &[usize]) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for one in 0..parts.len() {
        for other in one + 1..parts.len() {
            if surviving[one] == 0 || surviving[other] == 0 {
                continue;
            }
            // Neighbouring time constants of one effect resemble each other by nature.
            let same = std::ptr::eq(parts[one].instance, parts[other].instance);
            if same && parts[one].shape.iter().any(|x| x.fract() != 0.0) {
                continue;
            }
            let correlations = view.correlations(&information.parts[one], &information.parts[other]);
            let shared = correlations.iter().filter(|c| **c > ALIAS).count();
            if shared == 0 {
                continue;
            }
            let same_effects = |pair: &Pair| {
                !same
                    && std::ptr::eq(parts[pair.one].instance, parts[one].instance)
                    && std::ptr::eq(parts[pair.other].instance, parts[other].instance)
            };
            match pairs.iter_mut().find(|pair| same_effects(pair)) {
                Some(known) if known.shared >= shared => {}
                Some(known) => *known = Pair { one, other, shared },
                None => pairs.push(Pair { one, other, shared }),
            }
        }
    }
    pairs
}

/// For each pair the cheapest candidate in which fewer directions coincide.
fn breakers(
    machine: &Machine,
    cycle: &Cycle,
    states: &[State],
    parts: &[Part<'_>],
    pairs: &[Pair],
    options: &Options,
) -> Result<Vec<Option<(String, f64)>>, PlanError> {
    let mut involved: Vec<usize> = pairs.iter().flat_map(|pair| [pair.one, pair.other]).collect();
    involved.sort_unstable();
    involved.dedup();
    let chosen: Vec<Part<'_>> = involved.iter().map(|&p| parts[p].clone()).collect();
    let at = |p: usize| involved.binary_search(&p).expect("every pair is involved");
    let mut found: Vec<Option<(String, f64)>> = vec![None; pairs.len()];
    if pairs.is_empty() {
        return Ok(found);
    }
    for candidate in candidates(machine, &cycle.setups, states, &options.pace) {
        let Ok(visits) = candidate.cycle.visits(machine, &options.pace) else { continue };
        let minutes = visits.duration_s / 60.0;
        let cheaper = |known: &Option<(String, f64)>| known.as_ref().is_none_or(|(_, m)| minutes < *m);
        if !found.iter().any(cheaper) || !within_feeds(machine, &visits.states, &options.pace) {
            continue;
        }
        let states = thinned(visits.states, options.most_points);
        let experiment = imagined(machine, &candidate.cycle.setups, &states, candidate.cycle.run_kind())?;
        let information = white(&experiment, &chosen);
        let view = &information.views[0];
        for (pair, known) in pairs.iter().zip(&mut found) {
            let (one, other) = (&information.parts[at(pair.one)], &information.parts[at(pair.other)]);
            let directions = [one, other].map(|range| view.inverse_root(range).ncols());
            let shared = view.correlations(one, other).iter().filter(|c| **c > ALIAS).count();
            // Both must show, and no direction may coincide any more.
            if directions[0] > 0 && directions[1] > 0 && shared == 0 && cheaper(known) {
                *known = Some((candidate.cycle.name.clone(), minutes));
            }
        }
    }
    Ok(found)
}

fn label(part: &Part<'_>, experiment: &Experiment) -> String {
    let id = part.instance.id();
    if part.shape.is_empty() {
        return id;
    }
    let names = part.instance.shapes(&experiment.scene).names;
    let shape: Vec<String> = names
        .iter()
        .zip(&part.shape)
        .map(|(name, value)| {
            let value = (value * 1e3).round() / 1e3;
            format!("{name} {value} {}", Unit::in_name(name).text()).trim_end().to_string()
        })
        .collect();
    format!("{id} ({})", shape.join(", "))
}
