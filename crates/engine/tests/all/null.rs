//! Sixteen runs of a good machine with noise as machines make it: hardly anything may be claimed, and silence is no way out.

use crate::common::points_run;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::Joint;
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
use trunnion_engine::{Experiment, Verdict, diagnose};

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[test]
fn noise_of_real_machines_is_not_taken_for_an_effect() {
    let (mut claims, mut undecided) = (Vec::new(), Vec::new());
    for seed in 0..16 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut run = points_run("points-nothing-hidden");
        // White 0.3 µm, a wander of 0.2 µm over 6 minutes in machine axes, 1.5 µrad at each positioning of B, 1 % outliers.
        let (mut drift, mut angle_rad, mut last) = ([0.0; 3].map(|_: f64| normal(&mut rng)), 0.0, None);
        let keep = (-4.0_f64 / 360.0).exp();
        for point in &mut run.points {
            let (b, c) = (point.state.position[Joint::B], point.state.position[Joint::C]);
            let station = (b.to_bits(), point.state.direction[Joint::B] > 0.0, point.state.setup);
            if last != Some(station) {
                angle_rad = 1.5e-6 * normal(&mut rng);
                last = Some(station);
            }
            drift = drift.map(|x| keep * x + (1.0 - keep * keep).sqrt() * normal(&mut rng));
            let place = Joint::LINEAR.map(|l| point.state.position[l]);
            let tilt = [place[2] * angle_rad, 0.0, -place[0] * angle_rad];
            let machine: [f64; 3] = std::array::from_fn(|k| 0.2e-3 * drift[k] + tilt[k]);
            // Into table axes: back by B about Y, then by C about Z.
            let (sin_b, cos_b) = b.sin_cos();
            let frame = [
                cos_b * machine[0] - sin_b * machine[2],
                machine[1],
                sin_b * machine[0] + cos_b * machine[2],
            ];
            let (sin_c, cos_c) = c.sin_cos();
            let table = [cos_c * frame[0] + sin_c * frame[1], -sin_c * frame[0] + cos_c * frame[1], frame[2]];
            point.reading_mm = table.map(|x| x + 0.3e-3 * normal(&mut rng));
            if normal(&mut rng) > 2.33 {
                point.reading_mm = point.reading_mm.map(|x| x + 5e-3 * normal(&mut rng));
            }
        }
        let model = Model::base(&run.machine.name);
        let experiment = Experiment::new(&[run]).unwrap();
        let diagnosis = diagnose(&experiment, &model, &Options::default()).unwrap();
        if diagnosis.verdict == Verdict::Undecided {
            undecided.push((seed, diagnosis.why));
        } else if diagnosis.verdict != Verdict::NoiseFloor {
            let first = diagnosis.candidates.first().map(|c| (c.effect.clone(), c.evidence));
            claims.push((seed, first, diagnosis.formula.map(|f| (f.expression, f.evidence))));
        }
    }
    assert!(claims.len() <= 1, "claims at {claims:?}");
    assert!(undecided.is_empty(), "undecided at {undecided:?}");
}
