//! In white noise, for which they are made, the methods are right.

use super::{BASELINES, Library, named};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeSet;

const ROWS: usize = 600;
const EFFECTS: usize = 20;

fn normals(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| StandardNormal.sample(rng)).collect()
}

/// Effects of two columns each, of sizes that differ by a factor of a thousand: the methods must not see that.
fn library(rng: &mut ChaCha8Rng) -> Library {
    let scaled = |(k, x): (usize, f64)| x * 1e3_f64.powi((k / ROWS) as i32 % 2);
    let values = normals(rng, ROWS * 2 * EFFECTS).into_iter().enumerate().map(scaled);
    Library {
        columns: DMatrix::from_iterator(ROWS, 2 * EFFECTS, values),
        effect_of: (0..2 * EFFECTS).map(|j| format!("effect-{}", j / 2)).collect(),
        block_of: (0..2 * EFFECTS).map(|j| j / 2).collect(),
    }
}

/// How often each method names exactly the planted effects, each as large as the noise, in 20 runs.
fn exact(planted: &[usize]) -> Vec<usize> {
    let mut counts = vec![0; BASELINES.len()];
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let library = library(&mut rng);
        let mut readings = DVector::from_vec(normals(&mut rng, ROWS));
        for effect in planted {
            for j in [2 * effect, 2 * effect + 1] {
                readings += library.columns.column(j).normalize() * (0.5 * ROWS as f64).sqrt();
            }
        }
        let wanted: BTreeSet<String> = planted.iter().map(|effect| format!("effect-{effect}")).collect();
        for (count, named) in counts.iter_mut().zip(named(&library, &readings)) {
            *count += usize::from(named == wanted);
        }
    }
    counts
}

/// ln 600 = 6.4 is χ² of one column at 1 %: of 40 columns a third of runs has one, of STLSQ and OMP.
#[test]
fn a_planted_effect_is_named_in_white_noise() {
    for (baseline, exact) in BASELINES.iter().zip(exact(&[7])) {
        assert!(exact >= 12, "{}: {exact} of 20", baseline.name);
    }
}

#[test]
fn two_planted_effects_are_named_in_white_noise() {
    for (baseline, exact) in BASELINES.iter().zip(exact(&[3, 12])) {
        assert!(exact >= 12, "{}: {exact} of 20", baseline.name);
    }
}

#[test]
fn without_an_effect_nothing_is_kept_for_its_size_alone() {
    for (baseline, silent) in BASELINES.iter().zip(exact(&[])) {
        assert!(silent >= 12, "{}: {silent} of 20", baseline.name);
    }
}
