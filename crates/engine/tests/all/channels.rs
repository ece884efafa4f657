//! One probe that scatters several times as much as the other two is noise of that probe: it is no effect, it takes nothing from what the
//! others show, and no reading of it is an outlier for that.

use crate::common::{points_run, set};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
use trunnion_engine::{Diagnosis, Experiment, Verdict, diagnose};

/// White noise that the committed sets have in every channel, and that one of them gets in addition, µm.
const WHITE_UM: f64 = 0.3;
const OF_ONE_UM: f64 = 1.8;
/// Four for each channel.
const SEEDS: u64 = 12;

fn with_a_restless_channel(folder: &str, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut run = points_run(folder);
    for point in &mut run.points {
        let off: f64 = StandardNormal.sample(&mut rng);
        point.reading_mm[seed as usize % 3] += 1e-3 * OF_ONE_UM * off;
    }
    run
}

fn diagnosed(run: Run) -> Diagnosis {
    let model = Model::base(&run.machine.name);
    diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap()
}

#[test]
fn it_is_noise_and_the_repeatability_holds_it() {
    let of_a_reading_um = (WHITE_UM.powi(2) + OF_ONE_UM.powi(2) / 3.0).sqrt();
    for seed in 0..SEEDS {
        let nothing = diagnosed(with_a_restless_channel("points-nothing-hidden", seed));
        assert_eq!(nothing.verdict, Verdict::NoiseFloor, "{seed}: {}", nothing.why);
        // 168 differences of the channel: 8 % at one standard deviation of their root mean square, with a third fewer that are independent.
        let noise_um = nothing.residual.noise_um.expect("poses were measured twice");
        assert!(
            (noise_um / of_a_reading_um - 1.0).abs() < 0.25,
            "{seed}: {noise_um} instead of {of_a_reading_um} µm"
        );
        let white_um = nothing.noise.white_um;
        assert!(
            (white_um / of_a_reading_um - 1.0).abs() < 0.15,
            "{seed}: {white_um} instead of {of_a_reading_um} µm"
        );
    }
}

#[test]
fn an_effect_that_the_other_channels_show_has_its_name_and_explains_all() {
    for seed in 0..SEEDS {
        let sag = diagnosed(with_a_restless_channel("points-gravity", seed));
        assert_eq!(set(&sag), ["gravity-sag:B"], "{seed}: {}", sag.why);
        assert!(sag.formula.is_none() && sag.candidates[0].adequate(), "{seed}: {}", sag.why);
    }
}
