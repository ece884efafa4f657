//! No file panics its reader. Each is seeded with good ones.

#![no_main]

mod chosen;
#[expect(dead_code, reason = "which files an entry covers is asked by a test")]
#[path = "../../tests/all/fuzzed/entry.rs"]
mod entry;
#[path = "../../tests/all/fuzzed/files.rs"]
mod files;
#[path = "../../tests/all/fuzzed/recordings.rs"]
mod recordings;

use entry::Entry;
use files::FILES;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static CHOSEN: LazyLock<&Entry> = LazyLock::new(|| chosen::of(FILES, |entry| entry.name));

fuzz_target!(
    init: chosen::seed(&(CHOSEN.seeds)()),
    |data: &[u8]| (CHOSEN.read)(data)
);
