//! Of readings with nothing but noise, no more than one answer in twenty says that anything is significant.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Point, Quality};
use trunnion_cycles::{Cycle, Pace, Run};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::findings::Cell;
use trunnion_methods::recipes::MethodOptions;
use trunnion_methods::{Findings, recipes};

const UM: f64 = 1e-3;
const RUNS: u64 = 120;
/// 5 % of the runs and three standard deviations of a binomial.
const MOST: usize = 13;

/// A shipped cycle on a perfect machine, read with white noise of 0.3 µm.
pub fn empty(name: &str, seed: u64) -> Run {
    let path = format!("{}/../../config/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let cycle = Cycle::parse(name, &text).unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let pace = Pace { points_per_s: 2.0, ..Pace::default() };
    let states = cycle.visits(&machine, &pace).unwrap_or_else(|error| panic!("{error}")).states;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let point = |state: trunnion_core::State| {
        let setup = &cycle.setups[state.setup];
        let (mut reading, count) =
            (predict(&machine, setup, &state, &Errors::default()), setup.instrument.components().len());
        (0..count).for_each(|k| reading[k] += 0.3 * UM * noise());
        let reading_mm = reading.into();
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points = states.into_iter().map(point).collect();
    let (kind, setups) = (cycle.run_kind(), cycle.setups.clone());
    Run { name: name.into(), machine: machine.clone(), kind, setups, channels: vec![], points }
}

fn claims(findings: &Findings) -> Vec<String> {
    let of = |caption: &'static str| {
        let tables = findings.tables.iter().filter(move |table| table.caption.starts_with(caption));
        tables.flat_map(|table| &table.rows)
    };
    let text = |cell: &Cell| if let Cell::Text(text) = cell { text.clone() } else { String::new() };
    let waves = of("Error motions as harmonics").filter(|row| !text(&row[6]).contains("not significant"));
    let likely = of("Likely causes").chain(waves).map(|row| format!("{} {}", text(&row[0]), text(&row[1])));
    let words = findings
        .values
        .iter()
        .filter(|value| value.note.contains("likely:") || value.note.contains(" a turn: "));
    likely.chain(words.map(|value| value.name.clone())).collect()
}

#[test]
fn nothing_is_significant_in_noise_but_in_one_answer_of_twenty() {
    let rates = [
        ("two-height", &["two-height-c-static"][..]),
        ("rotary-values", &["rotary-values-c"]),
        ("ball-bar", &["s4-c", "s4-b"]),
    ]
    .map(|(name, cycles)| {
        let method = recipes::find(name).unwrap();
        let said = |seed: u64| {
            let runs: Vec<Run> = cycles.iter().zip(0..).map(|(name, k)| empty(name, 2 * seed + k)).collect();
            claims(&method.apply(&runs, &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}")))
        };
        let false_claims: Vec<Vec<String>> = (0..RUNS).map(said).filter(|said| !said.is_empty()).collect();
        println!("{name}: {} of {RUNS}", false_claims.len());
        (name, false_claims)
    });
    for (name, false_claims) in rates {
        assert!(false_claims.len() <= MOST, "{name}: {false_claims:?}");
    }
}
