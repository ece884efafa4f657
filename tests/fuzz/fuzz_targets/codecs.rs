//! No bytes panic a codec, and any split of them decodes the same. The first two bytes say where they are split.

#![no_main]

#[expect(dead_code, reason = "good frames behind garbage are a property test")]
#[path = "../../../crates/protocol/tests/all/codecs.rs"]
mod codecs;
mod chosen;

use codecs::{CODECS, Entry};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static CHOSEN: LazyLock<&Entry> = LazyLock::new(|| {
    let names: Vec<&str> = CODECS.iter().map(|entry| entry.name).collect();
    let name = chosen::name(&names);
    CODECS.iter().find(|entry| entry.name == name).expect("it is in the table")
});

fuzz_target!(
    init: {
        let frame = (CHOSEN.frame)();
        chosen::seed(&[[&[0, 0], &frame[..]].concat(), [&[9, 3], &frame.repeat(3)[..]].concat()]);
    },
    |data: &[u8]| {
        let Some((cuts, bytes)) = data.split_first_chunk::<2>() else { return };
        let (mut whole, mut split) = ((CHOSEN.new)(), (CHOSEN.new)());
        let expected = whole.push(bytes);
        let at = |cut: u8| usize::from(cut).min(bytes.len());
        let (first, second) = (at(cuts[0].min(cuts[1])), at(cuts[0].max(cuts[1])));
        let parts = [&bytes[..first], &bytes[first..second], &bytes[second..]];
        let got: Vec<String> = parts.into_iter().flat_map(|part| split.push(part)).collect();
        assert_eq!(got, expected);
        assert_eq!(split.losses(), whole.losses());
    }
);
