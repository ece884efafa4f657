//! Which entry of a table is fuzzed, and its seeds.

use std::path::Path;

/// The name in TRUNNION_FUZZ; every name of the table, one a line, where it says `list`.
pub fn name(names: &[&str]) -> String {
    let chosen = std::env::var("TRUNNION_FUZZ").unwrap_or_default();
    if chosen == "list" {
        names.iter().for_each(|name| println!("{name}"));
        std::process::exit(0);
    }
    assert!(names.contains(&chosen.as_str()), "TRUNNION_FUZZ = \"{chosen}\"; allowed: list, {names:?}");
    chosen
}

/// Writes seeds into the folder TRUNNION_FUZZ_CORPUS, before the fuzzer reads it.
pub fn seed(seeds: &[Vec<u8>]) {
    let folder = std::env::var("TRUNNION_FUZZ_CORPUS").expect("a folder in TRUNNION_FUZZ_CORPUS");
    std::fs::create_dir_all(&folder).expect("a folder of the corpus");
    for (k, bytes) in seeds.iter().enumerate() {
        std::fs::write(Path::new(&folder).join(format!("seed-{k}")), bytes).expect("a seed");
    }
}
