//! No text and no bytes panic what reads them: every reader gets good inputs that were changed, the same ones in every run. The fuzzer in
//! `tests/fuzz` reads the same tables, for longer (docs/measured/fuzz.md).

mod entry;
mod files;
mod received;
mod recordings;

use entry::Entry;
use files::FILES;
use rand::{Rng, RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use received::RECEIVED;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Changed inputs of each entry.
const CASES: usize = 10_000;
/// Longest input, bytes.
const LONGEST: usize = 4096;

fn entries() -> impl Iterator<Item = &'static Entry> {
    FILES.iter().chain(RECEIVED)
}

/// A place among so many; 0 of none.
fn below(rng: &mut impl Rng, count: usize) -> usize {
    if count == 0 { 0 } else { rng.random_range(0..count) }
}

/// One to eight changes: a byte, a piece left out, a piece of a seed put in, a piece repeated, the end cut off.
fn changed(seeds: &[Vec<u8>], rng: &mut impl Rng) -> Vec<u8> {
    let mut bytes = seeds[below(rng, seeds.len())].clone();
    bytes.truncate(LONGEST);
    for _ in 0..rng.random_range(1..=8) {
        let from = below(rng, bytes.len());
        let to = (from + below(rng, 40)).min(bytes.len());
        match rng.random_range(0..5) {
            0 if !bytes.is_empty() => bytes[from] = rng.random(),
            1 => drop(bytes.drain(from..to)),
            2 => {
                let other = &seeds[below(rng, seeds.len())];
                let begins = below(rng, other.len());
                let ends = (begins + below(rng, 40)).min(other.len());
                bytes.splice(from..to, other[begins..ends].iter().copied());
            }
            3 => {
                let piece = bytes[from..to].to_vec();
                bytes.splice(from..from, piece);
            }
            _ if rng.random_bool(0.1) => bytes.truncate(from),
            _ => {}
        }
    }
    bytes
}

#[test]
fn nothing_that_is_changed_panics_its_reader() {
    let mut wrong = Vec::new();
    for entry in entries() {
        let seeds = (entry.seeds)();
        assert!(!seeds.is_empty(), "{}: no seed", entry.name);
        let mut rng = ChaCha8Rng::seed_from_u64(20_261_130);
        let inputs = seeds.iter().cloned().chain((0..CASES).map(|_| changed(&seeds, &mut rng)));
        for input in inputs {
            if catch_unwind(AssertUnwindSafe(|| (entry.read)(&input))).is_err() {
                wrong.push(format!("{}: {:?}", entry.name, String::from_utf8_lossy(&input)));
                break;
            }
        }
    }
    assert!(wrong.is_empty(), "these panic:\n{}", wrong.join("\n"));
}

/// Where text and bytes become something.
const ENTRANCES: &[&str] = &[
    "Document::parse(",
    "serde_json::from_s",
    "Reader::from_str(",
    "ReaderBuilder::new(",
    "Payload::decode(",
    "DeTable::parse(",
];

/// Files with an entrance for what this program wrote itself, or what another entry's reader has read before.
const OWN: &[(&str, &str)] = &[
    ("cli/src/commands/check_config.rs", "a configuration that was read"),
    ("cli/src/commands/check_config/reach.rs", "a configuration that was read"),
    ("core/src/input.rs", "what every hand-written file goes through"),
    ("service/src/board.rs", "our own topics"),
    ("service/src/caller.rs", "the answer of our own service"),
    ("service/src/daemon/analyst.rs", "the answer of our own process"),
    ("service/src/kept_story.rs", "kept by ourselves"),
    ("service/src/page/analysed.rs", "the question of our own process"),
    ("service/src/page/analyst.rs", "the answer of our own process"),
    ("service/src/page/context.rs", "our own topics"),
    ("trunnion/src/history/keeper.rs", "kept by ourselves"),
    ("trunnion/src/kept.rs", "kept by ourselves"),
    ("trunnion/src/recorded.rs", "the configuration of a recording, read by the rules of configurations"),
];

#[test]
fn every_reader_of_what_comes_from_outside_is_fuzzed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let mut found = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(&root).unwrap().display().to_string();
            // Tests read what they wrote.
            let is_of_tests =
                name.contains("/tests/") || name.ends_with("tests.rs") || name.contains("/examples/");
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") && name.contains("/src/") && !is_of_tests {
                let text = std::fs::read_to_string(&path).unwrap();
                let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
                if ENTRANCES.iter().any(|entrance| shipped.contains(entrance)) {
                    found.push(name);
                }
            }
        }
    }
    found.sort();
    let named = |name: &String| {
        entries().any(|entry| entry.read_in.contains(&name.as_str()))
            || OWN.iter().any(|(own, _)| own == name)
    };
    let missing: Vec<&String> = found.iter().filter(|name| !named(name)).collect();
    assert!(
        missing.is_empty(),
        "{missing:?} read text or bytes: name each in `read_in` of an entry in tests/tests/all/fuzzed"
    );
    let gone: Vec<_> = OWN.iter().filter(|(own, _)| !found.iter().any(|name| name == own)).collect();
    assert!(gone.is_empty(), "{gone:?} have no entrance any more");
}
