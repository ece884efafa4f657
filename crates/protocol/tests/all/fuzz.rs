//! The promises of the crate, kept by every codec that takes a byte stream: any split decodes the same, no input
//! panics, garbage is counted, and good frames behind garbage are found. One table, one harness; a new codec is a line.

use super::codecs::{CODECS, Entry};
use proptest::prelude::*;

#[test]
fn every_codec_is_in_the_table() {
    // Frames and lines that codecs are made of; no stream of their own.
    let parts = ["can", "lines", "lib"];
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src")).unwrap() {
        let codec = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        assert!(
            parts.contains(&codec.as_str()) || CODECS.iter().any(|entry| entry.name.starts_with(&codec)),
            "crates/protocol/tests/all/codecs.rs: CODECS needs an entry whose name begins with \"{codec}\""
        );
    }
}

/// Bytes, pieces of good frames, and whole ones, mixed.
fn soup(frame: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let piece = {
        let frame = frame.clone();
        (any::<prop::sample::Index>(), any::<prop::sample::Index>()).prop_map(move |(from, to)| {
            let (from, to) = (from.index(frame.len()), to.index(frame.len()));
            frame[from.min(to)..=from.max(to)].to_vec()
        })
    };
    let part = prop_oneof![prop::collection::vec(any::<u8>(), 1..30), piece, Just(frame)];
    prop::collection::vec(part, 0..12).prop_map(|parts| parts.concat())
}

fn run(property: impl Fn(&Entry) -> Result<(), TestCaseError>) {
    for entry in CODECS {
        if let Err(error) = property(entry) {
            panic!("{}: {error}", entry.name);
        }
    }
}

fn cases(entry: &Entry, check: impl Fn(Vec<u8>, Vec<prop::sample::Index>) -> Result<(), TestCaseError>) {
    let cuts = prop::collection::vec(any::<prop::sample::Index>(), 0..8);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        // `PROPTEST_CASES` may ask for more.
        cases: ProptestConfig::default().cases.max(512),
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let outcome = runner.run(&(soup((entry.frame)()), cuts), |(bytes, cuts)| check(bytes, cuts));
    assert!(outcome.is_ok(), "{}: {}", entry.name, outcome.unwrap_err());
}

#[test]
fn any_split_of_any_bytes_decodes_the_same() {
    for entry in CODECS {
        cases(entry, |bytes, cuts| {
            let mut whole = (entry.new)();
            let mut split = (entry.new)();
            let expected = whole.push(&bytes);
            let mut at: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
            at.extend([0, bytes.len()]);
            at.sort_unstable();
            let got: Vec<String> =
                at.windows(2).flat_map(|pair| split.push(&bytes[pair[0]..pair[1]])).collect();
            prop_assert_eq!(got, expected);
            prop_assert_eq!(split.losses(), whole.losses());
            Ok(())
        });
    }
}

/// Two lengths run together (`Content-length: 1717`) are a well-formed head: its body is waited for, and eight frames are shorter.
fn promises_a_long_body(garbage: &[u8]) -> bool {
    let text = String::from_utf8_lossy(garbage);
    let digits = |rest: &str| rest.trim_start().bytes().take_while(u8::is_ascii_digit).count();
    text.split("Content-length:").skip(1).any(|rest| digits(rest) > 2)
}

#[test]
fn good_frames_behind_any_garbage_are_found() {
    const FRAMES: usize = 8;
    for entry in CODECS {
        let alone = (entry.new)().push(&(entry.frame)());
        assert_eq!(alone.len(), 1, "{}: {alone:?}", entry.name);
        cases(entry, |garbage, _| {
            prop_assume!(!promises_a_long_body(&garbage));
            let mut codec = (entry.new)();
            codec.push(&garbage);
            let events = codec.push(&(entry.frame)().repeat(FRAMES));
            let found = events.iter().rev().take_while(|event| **event == alone[0]).count();
            prop_assert!(found >= FRAMES - entry.takes_along, "{} of {FRAMES}: {:?}", found, events);
            Ok(())
        });
    }
}

#[test]
fn garbage_is_counted() {
    run(|entry| {
        let mut codec = (entry.new)();
        codec.push(&[0xFF; 9]);
        codec.push(b"\r\n");
        codec.push(&(entry.frame)());
        prop_assert!(codec.losses() > 0);
        Ok(())
    });
}
