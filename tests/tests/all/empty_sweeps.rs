//! Sweeps of a machine without a hidden effect, fast and far out: what forming does to them is no error of the machine.

use trunnion::results::Verdict;
use trunnion_tests::section::write_or_compare;
use trunnion_tests::sweeps::Sweep;

const FEEDS_DEG_PER_MIN: [f64; 3] = [360.0, 1800.0, 7200.0];
const RADII_MM: [f64; 3] = [50.0, 150.0, 300.0];
/// Machine and noise; where an error of forming is largest, a second one.
const SEED: u64 = 11;
const ANOTHER_SEED: u64 = 12;
/// Of polling MTConnect adapters: 0.5 to 1 ms.
const JITTER_S: f64 = 0.6e-3;
/// Noise of the virtual machine alone: 0.2 µm a sample, natural motion, offsets and drift of passes about 0.15 µm each, which make
/// 0.3 to 0.4 µm. An error that grows with the square of the feed, 5.5 µm at 300 mm, fits no model that holds for all feeds.
const LARGEST_RMS_UM: f64 = 0.5;

#[test]
fn empty_sweeps_keep_their_samples_and_leave_the_noise_at_every_feed_and_radius() {
    let mut table = String::from(
        "| feeds, °/min | radius, mm | seed | samples | used | jitter of the stamps | excluded | points | rms | answer |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut wrong = Vec::new();
    let each = FEEDS_DEG_PER_MIN.iter().map(|feed| (vec![*feed], &RADII_MM[..], SEED));
    // An error that grows with the feed is largest far out.
    let far_out = &RADII_MM[2..];
    let last =
        [(vec![FEEDS_DEG_PER_MIN[2]], far_out, ANOTHER_SEED), (FEEDS_DEG_PER_MIN.to_vec(), far_out, SEED)];
    for (feeds_deg_per_min, radii_mm, seed) in each.chain(last) {
        for &radius_mm in radii_mm {
            let feeds: Vec<String> = feeds_deg_per_min.iter().map(|feed| format!("{feed:.0}")).collect();
            let feeds_deg_per_min = feeds_deg_per_min.clone();
            let sweep = Sweep { feeds_deg_per_min, radius_mm, jitter_s: JITTER_S, seed };
            let folder = tempfile::tempdir().unwrap();
            let experiment = trunnion::open(sweep.record(folder.path())).unwrap();
            let complete = experiment.complete();
            let samples = &complete.samples[0];
            let fit = experiment.fit(&experiment.base_model()).unwrap();
            let results = fit.results();
            let rms_um = results.rms_um;
            let excluded: usize = complete.excluded.iter().map(|part| part.count).sum();
            // All feeds together take a minute.
            let answer = (feeds.len() == 1).then(|| fit.diagnose().unwrap().results());
            let is_blamed = answer.as_ref().is_some_and(|answer| {
                matches!(answer.verdict, Verdict::MissingEffect | Verdict::UnnamedStructure)
                    || !answer.candidates.is_empty()
            });
            let row = format!(
                "| {} | {radius_mm:.0} | {seed} | {} | {:.1} % | {:.2} ms | {excluded} | {} | {rms_um:.2} µm | {} |\n",
                feeds.join(", "),
                samples.all,
                100.0 * samples.share_used,
                samples.jitter_ms,
                experiment.points().points.len(),
                answer.map_or("", |answer| answer.verdict.as_str()),
            );
            let jitter_is_known = (samples.jitter_ms - 1e3 * JITTER_S).abs() < 0.1;
            // A doubt would withhold the answer.
            let is_doubted = !results.doubts.is_empty();
            if samples.share_used < 0.95
                || rms_um > LARGEST_RMS_UM
                || !jitter_is_known
                || is_doubted
                || is_blamed
            {
                wrong.push(row.clone());
            }
            table += &row;
        }
    }
    println!("{table}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    write_or_compare("docs/measured/sweeps.md", "empty sweeps", &table);
}
