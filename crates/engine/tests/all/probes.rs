//! Probes that show large displacements differently from small ones: what deflects them in a cycle without known steps are the errors of the machine.

use crate::common::{points_run, set};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
use trunnion_engine::{Experiment, Verdict, diagnose};

/// m = d + q d² of each component, with a q of 1 µm rms and either sign, on the run without a hidden effect of a simulator that shares no code
/// with this program.
#[test]
fn curved_probes_have_their_name_and_their_curvatures() {
    for seed in 1..=4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut run = points_run("points-nothing-hidden");
        let count = run.points.len() as f64;
        let curvatures: [f64; 3] = std::array::from_fn(|k| {
            let rms = (run.points.iter().map(|p| p.reading_mm[k].powi(4)).sum::<f64>() / count).sqrt();
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            sign * 1e-3 / rms
        });
        for point in &mut run.points {
            for (reading_mm, q) in point.reading_mm.iter_mut().zip(curvatures) {
                *reading_mm += q * reading_mm.powi(2);
            }
        }
        let model = Model::base(&run.machine.name);
        let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
        assert_eq!(found.verdict, Verdict::MissingEffect, "{curvatures:?}: {}", found.why);
        assert_eq!(set(&found), ["probe-nonlinearity"], "{curvatures:?}");
        let candidate = found.candidates.iter().find(|c| c.effect == "probe-nonlinearity").unwrap();
        assert!(candidate.adequate(), "{curvatures:?}");
        for (name, injected) in ["x", "y", "z"].into_iter().zip(curvatures) {
            let fitted = candidate.parameters.iter().find(|parameter| parameter.name == name).unwrap();
            let (value, u) = fitted.value.zip(fitted.u).expect("seen in this cycle");
            // On screens in µm/mm².
            assert!(
                (value - 1e3 * injected).abs() < 4.0 * u,
                "{name} = {value} ± {u}, put in {}",
                1e3 * injected
            );
        }
    }
}
