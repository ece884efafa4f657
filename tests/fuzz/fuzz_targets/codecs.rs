//! No bytes panic a codec, and any split of them decodes the same. The first two bytes say where they are split.

#![no_main]

#[expect(dead_code, reason = "good frames behind garbage are a property test")]
#[path = "../../../crates/protocol/tests/all/codecs.rs"]
mod codecs;
mod chosen;

use codecs::{CODECS, Entry};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static CHOSEN: LazyLock<&Entry> = LazyLock::new(|| chosen::of(CODECS, |entry| entry.name));

fuzz_target!(
    init: {
        let frame = (CHOSEN.frame)();
        chosen::seed(&[[&[0, 0], &frame[..]].concat(), [&[9, 3], &frame.repeat(3)[..]].concat()]);
    },
    |data: &[u8]| {
        let Some((cuts, bytes)) = data.split_first_chunk::<2>() else { return };
        let at = |cut: u8| usize::from(cut).min(bytes.len());
        let (first, second) = (at(cuts[0].min(cuts[1])), at(cuts[0].max(cuts[1])));
        CHOSEN.codec.check_split(bytes, &[&bytes[..first], &bytes[first..second], &bytes[second..]]);
    }
);
