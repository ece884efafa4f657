//! Noise: repeatable by seed, and of the size the truth says.

use super::{RUN_S, low_and_high, table_bc};
use trunnion_core::State;
use trunnion_hil_sim::physics::{grid, simulate_points};
use trunnion_hil_sim::truth::Noise;
use trunnion_hil_sim::{Sampler, Truth, VirtualMachine};

fn states() -> Vec<State> {
    grid::compressed(grid::standard_bc(&table_bc(), &low_and_high()), RUN_S)
}

fn machine(seed: u64, noise: Noise) -> VirtualMachine {
    let mut truth = Truth::draw(&table_bc(), &low_and_high(), &[], RUN_S, seed).unwrap();
    truth.noise = noise;
    VirtualMachine::new(table_bc(), truth).unwrap()
}

fn read(machine: &VirtualMachine, run: u64) -> Vec<[f64; 3]> {
    let mut sampler = Sampler::new(machine, run);
    states().iter().map(|state| sampler.read_mm(machine, state)).collect()
}

/// Noise of one run, µm, every component.
fn noise_um(seed: u64, noise: Noise) -> Vec<f64> {
    let machine = machine(seed, noise);
    let ideal = simulate_points(&machine, &states());
    let noisy = read(&machine, 0);
    noisy.as_flattened().iter().zip(ideal.as_flattened()).map(|(a, b)| 1e3 * (a - b)).collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn a_seed_repeats_its_noise_and_another_run_does_not() {
    let machine = machine(7, Noise::real(RUN_S));
    assert_eq!(read(&machine, 0), read(&machine, 0));
    assert_ne!(read(&machine, 0), read(&machine, 1));
}

#[test]
fn white_noise_has_its_size_and_no_memory() {
    let noise = noise_um(3, Noise::WHITE);
    assert!((rms(&noise) - 0.3).abs() < 0.03, "{}", rms(&noise));
    let product: f64 = noise.windows(4).map(|w| w[0] * w[3]).sum::<f64>() / (noise.len() - 3) as f64;
    assert!(product.abs() < 0.01, "{product}");
}

#[test]
fn drift_has_its_size_and_its_correlation_time() {
    let only_drift = Noise { drift_mm: 0.2e-3, drift_time_s: 420.0, ..Noise::NONE };
    let states = states();
    let (mut here, mut later, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..60 {
        let noise = noise_um(seed, only_drift);
        // First and thirtieth point of the first pass; squared lengths, as the table turns between them.
        here += noise[..3].iter().map(|v| v * v).sum::<f64>();
        later += noise[90..93].iter().map(|v| v * v).sum::<f64>();
        count += 3.0;
    }
    assert!((here / count).sqrt() > 0.16 && (here / count).sqrt() < 0.24, "{}", (here / count).sqrt());
    assert!((later / count).sqrt() > 0.16 && (later / count).sqrt() < 0.24, "{}", (later / count).sqrt());
    // Increment between neighbours: variance 2σ²(1 − e^(−Δt/τ)); at B = 0 the table's Z is the machine's.
    let step_s = states[37].time_s.unwrap() - states[36].time_s.unwrap();
    let expected_um = 0.2 * (2.0 * (1.0 - (-step_s / 420.0).exp())).sqrt();
    let mut squares = Vec::new();
    for seed in 0..60 {
        let noise = noise_um(seed, only_drift);
        squares.extend((36..47).map(|point| noise[3 * point + 5] - noise[3 * point + 2]));
    }
    assert!((rms(&squares) / expected_um - 1.0).abs() < 0.15, "{} {expected_um}", rms(&squares));
}

#[test]
fn real_noise_is_a_little_more_than_white_with_one_outlier_in_a_hundred() {
    let machine = machine(11, Noise::real(RUN_S));
    let mut sampler = Sampler::new(&machine, 0);
    let (mut outliers, mut readings) = (0, 0);
    for _ in 0..20 {
        for state in states() {
            sampler.read_mm(&machine, &state);
            readings += 1;
            outliers += usize::from(sampler.last_outlier_mm() != [0.0; 3]);
        }
    }
    let share = outliers as f64 / readings as f64;
    assert!((share - 0.01).abs() < 0.005, "{share}");
    let quiet = noise_um(11, Noise { outlier_share: 0.0, ..Noise::real(RUN_S) });
    assert!(rms(&quiet) > 0.3 && rms(&quiet) < 0.5, "{}", rms(&quiet));
}

#[test]
fn natural_error_motions_stay_near_their_size() {
    let mut total = 0.0;
    for seed in 0..20 {
        let with = machine(seed, Noise { natural_motion_mm: 0.15e-3, ..Noise::NONE });
        let without = machine(seed, Noise::NONE);
        let (with, without) = (simulate_points(&with, &states()), simulate_points(&without, &states()));
        let apart: Vec<f64> =
            with.as_flattened().iter().zip(without.as_flattened()).map(|(a, b)| 1e3 * (a - b)).collect();
        assert!(rms(&apart) < 0.5);
        total += rms(&apart) / 20.0;
    }
    assert!(total > 0.1 && total < 0.3, "{total} µm");
}
