//! How the points of an experiment group: passes (run × setup × directions × feed) and blocks of the slowest axis within them.
//!
//! Errors that stay alike within a pass or at one position of the slow axis make residuals depend on each other; these
//! groups are what uncertainties and held-out proof count as independent (docs/design/statistics.md §5).

use crate::Experiment;
use crate::problem::poses::{count, number};
use std::collections::HashMap;
use trunnion_core::{Joint, Point, State};
use trunnion_cycles::RunKind;
use trunnion_effects::same_position;

/// Points with fewer than this share of their setup's points do not make a pass of their own.
const SMALLEST_PASS: f64 = 0.05;
/// A slow axis stands at no more than this many positions; else blocks are parts of the pass in order.
const MOST_POSITIONS: usize = 64;
/// Blocks of a pass without a slow axis.
const PARTS_OF_PASS: usize = 8;

/// Group of each point.
pub(crate) struct Passes {
    pub pass: Vec<usize>,
    pub passes: usize,
    /// Block within any pass.
    pub block: Vec<usize>,
    pub blocks: usize,
    /// pass × block, numbered densely.
    pub cluster: Vec<usize>,
    pub clusters: usize,
}

pub(crate) fn passes(experiment: &Experiment) -> Passes {
    let moving = moving_axes(experiment);
    let pass = pass_of_points(experiment, &moving);
    let block = block_of_points(experiment, &moving, &pass);
    let cluster = number(pass.iter().zip(&block));
    Passes { passes: count(&pass), blocks: count(&block), clusters: count(&cluster), pass, block, cluster }
}

/// Rotary axes that move, or all axes that move when none turns: fewest changes first.
pub(crate) fn moving_axes(experiment: &Experiment) -> Vec<Joint> {
    let changes = |letter: Joint| {
        let mut stood = experiment.points[0].state.position[letter];
        let moves = |point: &&Point| {
            let position = point.state.position[letter];
            let moved = (position - stood).abs() > same_position(letter.slot());
            if moved {
                stood = position;
            }
            moved
        };
        experiment.points.iter().filter(moves).count()
    };
    let joints = experiment.machine().joints();
    let moving = joints.into_iter().filter(|&letter| experiment.scene.moves(letter));
    let mut moving: Vec<(usize, Joint)> = moving.map(|letter| (changes(letter), letter)).collect();
    if moving.iter().any(|(_, letter)| letter.is_rotary()) {
        moving.retain(|(_, letter)| letter.is_rotary());
    }
    moving.sort();
    moving.into_iter().map(|(_, letter)| letter).collect()
}

fn pass_of_points(experiment: &Experiment, moving: &[Joint]) -> Vec<usize> {
    let key = |i: usize| {
        let state = &experiment.points[i].state;
        let heading: Vec<i8> = moving.iter().map(|&l| sign(state.direction[l])).collect();
        let feed = match experiment.kinds[experiment.run_of_point[i]] {
            RunKind::OnTheFly => feed_class(state, moving),
            RunKind::Static => 0,
        };
        (experiment.run_of_point[i], state.setup, heading, feed)
    };
    let keys: Vec<_> = (0..experiment.points.len()).map(key).collect();
    let (mut of_key, mut of_setup) = (HashMap::new(), HashMap::new());
    for key in &keys {
        *of_key.entry(key.clone()).or_insert(0) += 1;
        *of_setup.entry((key.0, key.1)).or_insert(0) += 1;
    }
    let large = |key: &(usize, usize, Vec<i8>, i32)| {
        f64::from(of_key[key]) >= SMALLEST_PASS * f64::from(of_setup[&(key.0, key.1)])
    };
    // The first point of an index comes back the other way: it belongs to the pass around it.
    let mut merged = keys.clone();
    for i in 0..keys.len() {
        if !large(&keys[i]) {
            let same_setup =
                |k: &usize| (keys[*k].0, keys[*k].1) == (keys[i].0, keys[i].1) && large(&keys[*k]);
            let near = (i + 1..keys.len()).find(same_setup).or_else(|| (0..i).rev().find(same_setup));
            if let Some(k) = near {
                merged[i] = keys[k].clone();
            }
        }
    }
    number(merged)
}

fn block_of_points(experiment: &Experiment, moving: &[Joint], pass: &[usize]) -> Vec<usize> {
    if let Some(&slow) = moving.first().filter(|_| moving.len() > 1) {
        let block = experiment.stands(&[slow]);
        if count(&block) <= MOST_POSITIONS {
            return block;
        }
    }
    let mut length = vec![0; count(pass)];
    for &p in pass {
        length[p] += 1;
    }
    let mut seen = vec![0; length.len()];
    pass.iter()
        .map(|&p| {
            seen[p] += 1;
            (seen[p] - 1) * PARTS_OF_PASS / length[p]
        })
        .collect()
}

/// Class of the feed of the axis that turns, in steps of √2; 0 at rest and where no rotary axis moves.
fn feed_class(state: &State, moving: &[Joint]) -> i32 {
    let rotary = moving.iter().filter(|letter| letter.is_rotary());
    let speed = rotary.fold(0.0_f64, |most, &letter| most.max(state.velocity[letter].abs()));
    if speed > 0.0 { (2.0 * speed.log2()).round() as i32 + 100 } else { 0 }
}

fn sign(direction: f64) -> i8 {
    if direction > 0.0 { 1 } else { -i8::from(direction < 0.0) }
}
