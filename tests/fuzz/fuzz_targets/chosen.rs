//! Which entry of a table is fuzzed, and its seeds.

use std::path::Path;

/// The entry named in TRUNNION_FUZZ; where that says `list`, every name of the table is printed, one a line.
pub fn of<E>(table: &'static [E], name: fn(&E) -> &'static str) -> &'static E {
    let chosen = std::env::var("TRUNNION_FUZZ").unwrap_or_default();
    if chosen == "list" {
        table.iter().for_each(|entry| println!("{}", name(entry)));
        std::process::exit(0);
    }
    table.iter().find(|entry| name(entry) == chosen).unwrap_or_else(|| {
        let names: Vec<&str> = table.iter().map(name).collect();
        panic!("TRUNNION_FUZZ = \"{chosen}\"; allowed: list, {names:?}")
    })
}

/// Writes seeds into the folder TRUNNION_FUZZ_CORPUS, before the fuzzer reads it.
pub fn seed(seeds: &[Vec<u8>]) {
    let folder = std::env::var("TRUNNION_FUZZ_CORPUS").expect("a folder in TRUNNION_FUZZ_CORPUS");
    std::fs::create_dir_all(&folder).expect("a folder of the corpus");
    for (k, bytes) in seeds.iter().enumerate() {
        std::fs::write(Path::new(&folder).join(format!("seed-{k}")), bytes).expect("a seed");
    }
}
