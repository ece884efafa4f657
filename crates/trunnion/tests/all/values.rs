//! Values travel: a model file predicts runs it was not fitted to, and knows how far days differ.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::path::{Path, PathBuf};
use trunnion::history::{Keeper, changed as changed_to};
use trunnion::results::DoubtReason;
use trunnion::{Error, Experiment, Fit, Model};

fn committed(folder: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(folder).join("points.csv")
}

/// Days of one machine that does not change, in a folder, and the fit of the first of them.
fn fitted_days(fitted: usize) -> (tempfile::TempDir, Vec<PathBuf>, Fit) {
    let folder = tempfile::tempdir().unwrap();
    let days = Days { coefficients: [8.0, -3.0], between_um_per_k: 0.0, drift: (0.0, 1.0), white_um: 0.3 };
    let (files, _) = days.write(folder.path(), 1);
    let fit = fit(&files[..fitted]);
    (folder, files, fit)
}

/// A sensor that stands still moves nothing; one that is not there may.
#[test]
fn a_run_without_a_temperature_that_carries_a_kept_value_is_refused() {
    let (_folder, files, fit) = fitted_days(2);
    let kept = fit.model().with_values(&fit.values("2026-03-01")).unwrap();
    let table = std::fs::read_to_string(&files[2]).unwrap();
    let changed = |change: &dyn Fn(&str) -> String| {
        std::fs::write(&files[2], table.lines().map(change).collect::<Vec<_>>().join("\n")).unwrap();
        trunnion::open(&files[2]).unwrap()
    };
    let without = changed(&|line| line.rsplit_once(',').unwrap().0.into());
    let refused = [kept.predict(&without).map(drop), kept.compare_frozen(&without).map(drop)];
    for refused in refused.into_iter().chain([fit.predict(&without).map(drop)]) {
        let error = trunnion::chain(&refused.unwrap_err());
        assert!(
            error.starts_with(
                "day2 cannot be predicted: thermal-expansion needs temperature channel \"ambient\"; there are bed. The model keeps ambient.x = −"
            ),
            "{error}"
        );
        assert!(error.ends_with(" µm/K of it. Record that too, or fit a model without it"), "{error}");
    }
    let runs = [&files[1], &files[2]].map(|file| vec![file.clone()]);
    let compared = changed_to(runs, fit.model(), &mut Keeper::default());
    assert!(matches!(compared, Err(Error::Lacks { .. })), "so says a history: {compared:?}");
    let at_rest = changed(&|line| match line.rsplit_once(',').unwrap() {
        (other, "ambient_degc") => format!("{other},ambient_degc"),
        (other, _) => format!("{other},20"),
    });
    assert!(kept.predict(&at_rest).is_ok());
}

#[test]
fn a_model_file_predicts_like_the_fit_that_left_its_values() {
    let run = trunnion::open(committed("points-gravity")).unwrap();
    let base = run.fit(&run.base_model()).unwrap();
    let step = base.add("gravity-sag:B").unwrap().dated("2026-03-01").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.model.toml");
    step.model().save(&file).unwrap();
    let kept = Model::load(&file).unwrap();
    let prediction = kept.predict(&run).unwrap();
    assert_eq!(prediction.fitted_on, "2026-03-01");
    assert!(prediction.runs[0].was_fitted, "these very points were fitted");
    assert!(!prediction.differences_known, "one run knows nothing of another");
    let of_fit = step.predict(&run).unwrap();
    assert_eq!((&prediction.runs, &prediction.not_determined), (&of_fit.runs, &of_fit.not_determined));
    assert!(prediction.runs[0].without_model_rms_um > 3.0 * prediction.runs[0].rms_um);

    let compared = kept.compare_frozen(&run).unwrap();
    assert!((compared.identification.rms_um / prediction.runs[0].rms_um - 1.0).abs() < 0.01);
    let fitted = step.fit().results();
    for frozen in compared.identification.parameters.iter().filter(|p| p.effect != "ball-setting") {
        let of_fit = fitted.parameters.iter().find(|p| p.name == frozen.name).unwrap();
        assert_eq!(frozen.value.is_none(), prediction.not_determined.contains(&frozen.name), "{frozen:?}");
        let near = |a: Option<f64>, b: Option<f64>| (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-3;
        assert!(near(frozen.value, of_fit.value) && near(frozen.u, of_fit.u), "{frozen:?} {of_fit:?}");
    }
    let text = trunnion::report::compare_text(&compared);
    assert!(
        text.starts_with("The fitted values predict these runs") && text.contains("no prediction"),
        "{text}"
    );

    // Values are of the whole model: with another effect they no longer count, without it they do again.
    let by_hand = format!("{}\n[[effect]]\nid = \"backlash:C\"\n", kept.text());
    let by_hand = Model::parse("m.toml", by_hand).unwrap();
    let refused = by_hand.predict(&run).unwrap_err();
    assert!(matches!(&refused, Error::NoValues { why } if why.contains("changed")), "{refused}");
    assert!(matches!(base.model().predict(&run), Err(Error::NoValues { .. })));
    let longer = run.fit(&kept).unwrap().add("backlash:C").unwrap().dated("2026-03-02").unwrap();
    assert_eq!(longer.model().predict(&run).unwrap().fitted_on, "2026-03-02");
    let without = longer.fit().remove("backlash:C", "2026-03-03", None).unwrap();
    let (left, removal) = without.model().text().split_once("\n[[removed]]\n").unwrap();
    assert_eq!(left, kept.text(), "removing undoes adding, values and all");
    assert_eq!(removal, "effect = \"backlash:C\"\ndate = \"2026-03-03\"\n");
    let middle = longer.fit().remove("gravity-sag:B", "2026-03-03", None).unwrap();
    assert_eq!(middle.model().predict(&run).unwrap().fitted_on, "2026-03-03", "fitted again");
}

/// What a diagnosis said for an effect was said with all others in the model: it stays when one of them goes, with the name of that one.
#[test]
fn what_was_found_stays_when_an_earlier_effect_is_taken_out() {
    let run = trunnion::open(committed("points-backlash-and-drift")).unwrap();
    let first = run.fit(&Model::base("table-bc")).unwrap().add("thermal-drift").unwrap();
    let both = first.dated("2026-03-01").unwrap().fit().add("backlash:C").unwrap();
    let both = both.dated("2026-03-02").unwrap();
    let alone = both.fit().remove("thermal-drift", "2026-03-03", None).unwrap();
    let row_of = |model: &Model| model.ladder().rows.last().unwrap().ladder.clone().unwrap();
    let (was, now) = (row_of(both.model()), row_of(alone.model()));
    assert!(was.evidence.is_some_and(|evidence| evidence > 1.0) && was.found_with.is_empty(), "{was:?}");
    assert_eq!(now.found_with, ["thermal-drift"]);
    assert_eq!((now.evidence, now.confused_with), (was.evidence, was.confused_with));
    assert_eq!(now.separate_by, was.separate_by);
}

const MODEL: &str = "format = \"trunnion-model/1\"\nmachine = \"three-axis\"\n[[effect]]\nid = \"location-errors\"\n\
                     [[effect]]\nid = \"ball-setting\"\n[[effect]]\nid = \"thermal-expansion\"\nshape = [0.0]\n";
const DAYS: usize = 6;
const SAMPLES: usize = 120;

/// A machine at rest whose length follows two temperatures; how much, differs from day to day.
struct Days {
    /// µm/K, mean of the days.
    coefficients: [f64; 2],
    /// Standard deviation from day to day, µm/K.
    between_um_per_k: f64,
    /// Standard deviation and time constant (samples) of an Ornstein–Uhlenbeck drift, µm.
    drift: (f64, f64),
    white_um: f64,
}

impl Days {
    /// One points file a day, and the true coefficients of the last.
    fn write(&self, folder: &Path, seed: u64) -> (Vec<PathBuf>, [f64; 2]) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let setup = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n[[setup]]\nname = \"rest\"\ninstrument = \"diagonal\"\n\
                     ball_in_table_mm = [0, 0, 0]\ndirection = [1, 0, 0]\n";
        std::fs::write(folder.join("setup.toml"), setup).unwrap();
        let mut last = self.coefficients;
        let mut files = Vec::new();
        for day in 0..DAYS {
            last = self.coefficients.map(|mean| mean + self.between_um_per_k * normal());
            let (warming_k, swing_k, phase) = (4.0 + normal(), 2.0 + 0.5 * normal(), normal());
            let kept = (-1.0 / self.drift.1).exp();
            let mut drift_um = self.drift.0 * normal();
            let mut text = String::from("setup,time_s,x_mm,y_mm,z_mm,l_mm,bed_degc,ambient_degc\n");
            for k in 0..SAMPLES {
                let t = k as f64 / SAMPLES as f64;
                let bed_k = warming_k * (1.0 - (-3.0 * t).exp());
                let ambient_k = swing_k * ((6.0 * t + phase).sin() - phase.sin());
                drift_um = kept * drift_um + (1.0 - kept * kept).sqrt() * self.drift.0 * normal();
                let l_um = last[0] * bed_k + last[1] * ambient_k + drift_um + self.white_um * normal();
                let [l_mm, bed, ambient] = [l_um * 1e-3, 20.0 + bed_k, 20.0 + ambient_k];
                text += &format!("rest,{},0,0,0,{l_mm:.6},{bed:.4},{ambient:.4}\n", 120 * k);
            }
            files.push(folder.join(format!("day{day}.csv")));
            std::fs::write(&files[day], text).unwrap();
        }
        (files, last)
    }
}

/// Over seeds: mean share of the last day inside the band of the days before, and share of its coefficients inside the interval
/// that u of another run gives.
fn cover(days: &Days, seeds: u64, fitted: usize) -> (f64, f64) {
    let (mut inside, mut coefficients) = (0.0, 0.0);
    for seed in 0..seeds {
        let folder = tempfile::tempdir().unwrap();
        let (files, truth) = days.write(folder.path(), seed);
        let fit = fit(&files[..fitted]);
        let last = trunnion::open(&files[DAYS - 1]).unwrap();
        let kept = fit.model().with_values(&fit.values("2026-03-01")).unwrap();
        let prediction = kept.predict(&last).unwrap();
        assert_eq!(prediction.differences_known, fitted > 1);
        inside += prediction.runs[0].inside_95_fraction / seeds as f64;
        for (name, truth) in ["bed.x", "ambient.x"].into_iter().zip(truth) {
            let answer = fit.results();
            let found = answer.parameter(name).unwrap();
            let u = found.u_another_run.or(found.u).unwrap();
            let hit = (found.value.unwrap() - truth).abs() <= 1.96 * u;
            coefficients += f64::from(u8::from(hit)) / (2 * seeds) as f64;
        }
    }
    (inside, coefficients)
}

fn fit(files: &[PathBuf]) -> Fit {
    let runs: Experiment = trunnion::open_all(files).unwrap();
    runs.fit(&Model::parse("m.toml", MODEL.into()).unwrap()).unwrap()
}

/// Shares of 20 days scatter by about 2 %, of 40 coefficients by 3.5 %: three of them below 95 %. Above nothing is asked of five
/// days: their u has to hold what five days alone do not tell.
#[test]
fn u_of_several_days_holds_what_the_next_day_shows() {
    let differing =
        Days { coefficients: [8.0, -3.0], between_um_per_k: 1.0, drift: (0.5, 10.0), white_um: 0.3 };
    let (inside, coefficients) = cover(&differing, 20, DAYS - 1);
    println!("days that differ: {inside:.3} of readings, {coefficients:.3} of coefficients");
    assert!(inside > 0.89 && coefficients > 0.84, "{inside} {coefficients}");
    let same_days = Days { between_um_per_k: 0.0, ..differing };
    let (inside, coefficients) = cover(&same_days, 20, DAYS - 1);
    println!("the same days: {inside:.3} of readings, {coefficients:.3} of coefficients");
    assert!(inside > 0.89 && coefficients > 0.84, "{inside} {coefficients}");
    // One day cannot know: this is what the others are for.
    let one = Days { between_um_per_k: 3.0, ..same_days };
    let (blind, _) = cover(&one, 10, 1);
    let (inside, _) = cover(&one, 10, DAYS - 1);
    println!("days that differ a lot: {blind:.3} from one, {inside:.3} from five");
    assert!(inside > 0.89 && blind < inside - 0.1, "{blind} {inside}");
}

#[test]
fn temperatures_that_change_together_and_impossible_coefficients_are_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let days = Days { coefficients: [8.0, -3.0], between_um_per_k: 0.0, drift: (0.0, 1.0), white_um: 0.3 };
    let (files, _) = days.write(folder.path(), 1);
    assert_eq!(fit(&files[..1]).results().doubts, []);
    // They follow their temperatures at once: no fault of the fit, so a remark before it is added and no doubt after.
    let day = trunnion::open_all(&files[..1]).unwrap();
    let found = day.fit(&day.base_model()).unwrap().diagnose().unwrap().results();
    let expansion = found.candidates.iter().find(|one| one.effect == "thermal-expansion").unwrap();
    assert!(
        expansion.remarks.iter().any(|remark| remark.starts_with("No lag was seen: tau_s")),
        "{expansion:?}"
    );
    // A third sensor next to the first, and a fourth far too sensitive.
    let table = std::fs::read_to_string(&files[0]).unwrap();
    let mut lines = table.lines();
    let mut text = format!("{},twin_degc,far_degc\n", lines.next().unwrap());
    for (k, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        let twin = cells[5] + 0.01 * ((k * 7) % 5) as f64;
        let far = 20.0 + 0.002 * (k as f64 * 0.9).sin();
        let l_mm = cells[4] + 0.5 * (far - 20.0);
        text += &format!("rest,{},0,0,0,{l_mm:.6},{},{},{twin:.4},{far:.6}\n", cells[0], cells[5], cells[6]);
    }
    let file = folder.path().join("twins.csv");
    std::fs::write(&file, text).unwrap();
    let fit = fit(&[file]);
    let doubts = fit.results().doubts;
    let of = |reason| doubts.iter().filter(move |doubt| doubt.reason == reason).flat_map(|d| d.names.clone());
    assert_eq!(of(DoubtReason::Collinear).collect::<Vec<_>>(), ["bed.x", "twin.x"], "{doubts:?}");
    assert_eq!(of(DoubtReason::BeyondPhysical).collect::<Vec<_>>(), ["far.x"], "{doubts:?}");
    let compared = fit.compare();
    let story = compared.story().wrong.join(" ");
    for surface in [fit.summary(), compared.summary(), compared.page(), story] {
        assert!(surface.contains("changed together") && surface.contains("far.x exceeds"), "{surface}");
    }
}

/// The same readings with another temperature are another run.
#[test]
fn a_run_with_another_temperature_or_direction_was_not_fitted() {
    let (_folder, files, fit) = fitted_days(1);
    let kept = fit.model().with_values(&fit.values("2026-03-01")).unwrap();
    let was_fitted = |file: &Path| kept.predict(&trunnion::open(file).unwrap()).unwrap().runs[0].was_fitted;
    assert!(was_fitted(&files[0]));
    let table = std::fs::read_to_string(&files[0]).unwrap();
    let warmer: Vec<String> = table.lines().map(|line| line.replace(",20.", ",21.")).collect();
    std::fs::write(&files[0], warmer.join("\n")).unwrap();
    assert!(!was_fitted(&files[0]), "another temperature");
    let mut lines = table.lines();
    let head = format!("{},direction_x\n", lines.next().unwrap());
    std::fs::write(&files[0], head + &lines.map(|line| format!("{line},1\n")).collect::<String>()).unwrap();
    assert!(!was_fitted(&files[0]), "another direction");
}

/// Of two sensors that read the same only what both do together is known: the one that stands for it keeps its value, and says so.
#[test]
fn a_value_that_is_taken_without_being_known_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let days = Days { coefficients: [8.0, -3.0], between_um_per_k: 0.0, drift: (0.0, 1.0), white_um: 0.3 };
    let (files, _) = days.write(folder.path(), 1);
    let table = std::fs::read_to_string(&files[0]).unwrap();
    let mut lines = table.lines();
    let mut text = format!("{},twin_degc\n", lines.next().unwrap());
    for line in lines {
        text += &format!("{line},{}\n", line.split(',').nth(6).unwrap());
    }
    std::fs::write(&files[0], text).unwrap();
    let fit = fit(&files[..1]);
    let kept = fit.model().with_values(&fit.values("2026-03-01")).unwrap();
    let run = trunnion::open(&files[0]).unwrap();
    let prediction = kept.predict(&run).unwrap();
    let names: Vec<&str> = prediction.taken.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, prediction.not_determined);
    let together: f64 = prediction.taken.iter().filter(|one| one.unit == "um/K").map(|one| one.value).sum();
    assert!((together - 8.0).abs() < 1.0, "{:?}", prediction.taken);
    let text = trunnion::report::prediction_text(&prediction);
    let compared = kept.compare_frozen(&run).unwrap().identification;
    for one in &prediction.taken {
        let value = trunnion::results::number::with_unit(one.value, &one.unit);
        assert!(text.contains(&format!("{} = {value}", one.name)), "{text}");
        let note = &compared.parameters.iter().find(|p| p.name == one.name).unwrap().note;
        assert!(note.ends_with(&format!("taken as {value}")), "{note}");
    }
}

/// A third sensor stands next to the first: the cause is found all the same, and that no coefficient is that of one sensor is said.
#[test]
fn a_thermal_day_has_its_cause_named_and_its_collinear_sensors_said() {
    let folder = tempfile::tempdir().unwrap();
    let days = Days { coefficients: [8.0, -3.0], between_um_per_k: 0.0, drift: (0.3, 10.0), white_um: 0.3 };
    let (files, _) = days.write(folder.path(), 2);
    let table = std::fs::read_to_string(&files[0]).unwrap();
    let mut lines = table.lines();
    let mut text = format!("{},twin_degc\n", lines.next().unwrap());
    for (k, line) in lines.enumerate() {
        let bed: f64 = line.split(',').nth(6).unwrap().parse().unwrap();
        text += &format!("{line},{:.4}\n", bed + 0.01 * ((k * 7) % 5) as f64);
    }
    let file = folder.path().join("twin.csv");
    std::fs::write(&file, text).unwrap();
    let run = trunnion::open(file).unwrap();
    let diagnosed = run.fit(&run.base_model()).unwrap().diagnose().unwrap();
    assert_eq!(diagnosed.best().as_deref(), Some("thermal-expansion"), "{}", diagnosed.summary());
    let fit = diagnosed.add("thermal-expansion").unwrap().fit().clone();
    let doubts = fit.results().doubts;
    let twins = doubts.iter().find(|doubt| doubt.reason == DoubtReason::Collinear);
    assert_eq!(
        twins.map(|doubt| &doubt.names[..]),
        Some(&["bed.x".to_string(), "twin.x".into()][..]),
        "{doubts:?}"
    );
    assert!(fit.summary().contains("changed together"), "{}", fit.summary());
}
