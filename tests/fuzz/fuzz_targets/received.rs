//! Nothing that the service is sent panics it.

#![no_main]

mod chosen;
#[expect(dead_code, reason = "which files an entry covers is asked by a test")]
#[path = "../../tests/all/fuzzed/entry.rs"]
mod entry;
#[path = "../../tests/all/fuzzed/received.rs"]
mod received;

use entry::Entry;
use libfuzzer_sys::fuzz_target;
use received::RECEIVED;
use std::sync::LazyLock;

static CHOSEN: LazyLock<&Entry> = LazyLock::new(|| chosen::of(RECEIVED, |entry| entry.name));

fuzz_target!(
    init: chosen::seed(&(CHOSEN.seeds)()),
    |data: &[u8]| (CHOSEN.read)(data)
);
