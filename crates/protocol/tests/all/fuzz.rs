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

fn cases(
    entry: &Entry,
    at_least: u32,
    check: impl Fn(Vec<u8>, Vec<prop::sample::Index>) -> Result<(), TestCaseError>,
) {
    let cuts = prop::collection::vec(any::<prop::sample::Index>(), 0..8);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        // `PROPTEST_CASES` may ask for more.
        cases: ProptestConfig::default().cases.max(at_least),
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let outcome = runner.run(&(soup((entry.frame)()), cuts), |(bytes, cuts)| check(bytes, cuts));
    assert!(outcome.is_ok(), "{}: {}", entry.name, outcome.unwrap_err());
}

#[test]
fn any_split_of_any_bytes_decodes_the_same() {
    for entry in CODECS {
        cases(entry, 10_000, |bytes, cuts| {
            let mut at: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
            at.extend([0, bytes.len()]);
            at.sort_unstable();
            let pieces: Vec<&[u8]> = at.windows(2).map(|pair| &bytes[pair[0]..pair[1]]).collect();
            entry.codec.check_split(&bytes, &pieces);
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
        let (mut events, _) = entry.codec.decode(&[&(entry.frame)()]);
        let alone = events.remove(0);
        assert_eq!(alone.len(), 1, "{}: {alone:?}", entry.name);
        cases(entry, 512, |garbage, _| {
            prop_assume!(!promises_a_long_body(&garbage));
            let (decoded, _) = entry.codec.decode(&[&garbage, &(entry.frame)().repeat(FRAMES)]);
            let events = &decoded[1];
            let found = events.iter().rev().take_while(|event| **event == alone[0]).count();
            prop_assert!(found >= FRAMES - entry.takes_along, "{} of {FRAMES}: {:?}", found, events);
            Ok(())
        });
    }
}

#[test]
fn garbage_is_counted() {
    run(|entry| {
        let (_, losses) = entry.codec.decode(&[&[0xFF; 9], b"\r\n", &(entry.frame)()]);
        prop_assert!(losses > 0);
        Ok(())
    });
}
