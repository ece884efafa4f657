//! A thermal day on which six sensors rise and fall together: an expression with one of the temperatures is `thermal-expansion` with the other
//! coefficients at zero, and has its name.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::path::PathBuf;
use trunnion_results::Verdict;

const SAMPLES: usize = 120;
const STEP_S: f64 = 120.0;
const SETUP: &str = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n[[setup]]\nname = \"rest\"\ninstrument = \"diagonal\"\n\
                     ball_in_table_mm = [0, 0, 0]\ndirection = [1, 0, 0]\n";

/// Heat that is on from a seventh of the day to six tenths of it.
fn warmed(final_k: f64, tau_s: f64) -> Vec<f64> {
    let mut risen_k = 0.0;
    let rise = |k: usize| {
        let target_k = if (18..72).contains(&k) { final_k } else { 0.0 };
        if k > 0 {
            risen_k += (target_k - risen_k) * (1.0 - (-STEP_S / tau_s).exp());
        }
        risen_k
    };
    (0..SAMPLES).map(rise).collect()
}

fn day(folder: &std::path::Path, seed: u64) -> PathBuf {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let swings = 0.4 + 0.05 * seed as f64;
    let ambient: Vec<f64> =
        (0..SAMPLES).map(|k| (std::f64::consts::TAU * swings * k as f64 / SAMPLES as f64).sin()).collect();
    let shared = warmed(7.0, 2400.0);
    let own: Vec<Vec<f64>> = (1..6).map(|i| warmed(0.4, 1200.0 + 600.0 * f64::from(i))).collect();
    let mut text = String::from("setup,time_s,x_mm,y_mm,z_mm,l_mm");
    ["ambient", "bed", "column", "spindle", "coolant", "motor"]
        .iter()
        .for_each(|name| text += &format!(",{name}_degc"));
    for k in 0..SAMPLES {
        let of_sensor = |i: usize| match i {
            0 => ambient[k],
            i => (0.3 + 0.15 * i as f64) * shared[k] + 0.6 * ambient[k] + own[i - 1][k],
        };
        let l_um = of_sensor(0) + 2.0 * of_sensor(2) + 3.0 * of_sensor(3) - of_sensor(5) + 0.6 * normal();
        text += &format!("\nrest,{},0,0,0,{:.6}", STEP_S * k as f64, l_um * 1e-3);
        (0..6).for_each(|i| text += &format!(",{:.2}", 20.0 + of_sensor(i)));
    }
    std::fs::write(folder.join("setup.toml"), SETUP).unwrap();
    let file = folder.join(format!("day{seed}.csv"));
    std::fs::write(&file, text + "\n").unwrap();
    file
}

/// One day of eight may go otherwise; where the expression was taken for something without a name, three to four of them did.
#[test]
fn temperatures_that_rise_together_are_an_expansion_and_no_unknown_effect() {
    let folder = tempfile::tempdir().unwrap();
    let named = (0..8).filter(|&seed| {
        let day = trunnion::open(day(folder.path(), seed)).unwrap();
        let found = day.fit(&day.base_model()).unwrap().diagnose().unwrap().results();
        found.verdict == Verdict::MissingEffect && found.candidates[0].effect == "thermal-expansion"
    });
    let named = named.count();
    assert!(named >= 7, "{named} of 8 named");
}
