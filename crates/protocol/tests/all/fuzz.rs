//! The promises of the crate, kept by every codec that takes a byte stream: any split decodes the same, no input
//! panics, garbage is counted, and good frames behind garbage are found. One table, one harness; a new codec is a line.

use proptest::prelude::*;
use std::fmt::Debug;
use trunnion_protocol::canopen::network::Message;
use trunnion_protocol::canopen::{NodeId, NodeStartup};
use trunnion_protocol::{ascii, keyence, linuxcncrsh, mtconnect, optoncdt, slcan};

/// A codec as the harness sees it: bytes in, events as text out, and what was lost.
trait Codec {
    fn push(&mut self, bytes: &[u8]) -> Vec<String>;
    /// Bytes or lines that became nothing.
    fn losses(&self) -> u64;
}

struct Of<D> {
    decoder: D,
    push: fn(&mut D, &[u8]) -> Vec<String>,
    losses: fn(&D) -> u64,
}

impl<D> Codec for Of<D> {
    fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        (self.push)(&mut self.decoder, bytes)
    }

    fn losses(&self) -> u64 {
        (self.losses)(&self.decoder)
    }
}

fn shown<T: Debug>(events: Vec<T>) -> Vec<String> {
    events.iter().map(|event| format!("{event:?}")).collect()
}

struct Entry {
    name: &'static str,
    new: fn() -> Box<dyn Codec>,
    /// One good frame; alone it gives one event.
    frame: fn() -> Vec<u8>,
    /// Good frames that garbage may take with it.
    takes_along: usize,
}

const CODECS: &[Entry] = &[
    Entry {
        name: "optoncdt",
        new: || {
            Box::new(Of {
                decoder: optoncdt::Decoder::new(optoncdt::BlockLength::Exactly(2)),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                losses: |decoder| decoder.counts().dropped_bytes,
            })
        },
        frame: || {
            let value = |raw| optoncdt::RawValue::new(raw).unwrap();
            optoncdt::encode_block(&optoncdt::Block { values: vec![value(32_760), value(77)] })
        },
        takes_along: 0,
    },
    Entry {
        name: "optoncdt commands",
        new: || {
            Box::new(Of {
                decoder: optoncdt::command::CommandDecoder::default(),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                // A sensor answers a line that is no command with an error: nothing is lost but what is too long.
                losses: |decoder| 1 + decoder.overlong_lines(),
            })
        },
        frame: || optoncdt::Command::get_info().encode(),
        takes_along: 1,
    },
    Entry {
        name: "keyence",
        new: || {
            Box::new(Of {
                decoder: keyence::Decoder::default(),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                losses: |decoder| decoder.counts().dropped_bytes,
            })
        },
        frame: || b"M0,+000.5000,-012.3456\r\n".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "keyence commands",
        new: || {
            Box::new(Of {
                decoder: keyence::CommandDecoder::default(),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                losses: |decoder| decoder.counts().dropped_bytes,
            })
        },
        frame: || keyence::Command::Read { amplifier: 6, data: 101 }.encode(),
        takes_along: 1,
    },
    Entry {
        name: "ascii, 8 bits",
        new: || indicator("mitutoyo-usb"),
        frame: || b"01A+0000.123\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "ascii, 7 bits",
        new: || indicator("mahr-c1202"),
        frame: || b"1 +003.25 um <\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "slcan",
        new: || {
            Box::new(Of {
                decoder: slcan::HostDecoder::default(),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                losses: |decoder| decoder.losses().dropped_bytes,
            })
        },
        frame: || b"t5818430010009401020089F4\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "slcan commands",
        new: || {
            Box::new(Of {
                decoder: slcan::AdapterDecoder::default(),
                push: |decoder, bytes| shown(decoder.push(bytes)),
                losses: |decoder| decoder.losses().dropped_bytes,
            })
        },
        frame: || b"t60184000100000000000\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "canopen",
        new: || {
            Box::new(Of {
                decoder: Canopen::new(),
                push: Canopen::push,
                losses: |c| c.frames.losses().dropped_bytes,
            })
        },
        frame: || b"t701105\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "linuxcncrsh",
        new: || {
            Box::new(Of {
                decoder: linuxcncrsh::Lines::default(),
                push: |decoder, bytes| {
                    let replies = decoder.push(bytes).into_iter().map(|line| linuxcncrsh::parse_reply(&line));
                    shown(replies.collect())
                },
                losses: linuxcncrsh::Lines::dropped_bytes,
            })
        },
        frame: || b"JOINT_POS 0 1.5\r\n".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "mtconnect multipart",
        new: || {
            Box::new(Of {
                decoder: mtconnect::MultipartDecoder::new("multipart/x-mixed-replace;boundary=xyz").unwrap(),
                push: |decoder, bytes| {
                    // The documents inside are read too: any body is a document or an error.
                    let parts = decoder.push(bytes).into_iter();
                    parts
                        .map(|part| {
                            format!("{part:?} {:?}", mtconnect::parse(&part.body).map_err(|e| e.to_string()))
                        })
                        .collect()
                },
                losses: |decoder| decoder.losses().dropped_bytes,
            })
        },
        frame: || mtconnect::encode_part("xyz", "text/xml", b"<MTConnectError/>"),
        takes_along: 3,
    },
];

#[test]
fn every_codec_is_in_the_table() {
    // Frames and lines that codecs are made of; no stream of their own.
    let parts = ["can", "lines", "lib"];
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src")).unwrap() {
        let codec = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        assert!(
            parts.contains(&codec.as_str()) || CODECS.iter().any(|entry| entry.name.starts_with(&codec)),
            "crates/protocol/tests/all/fuzz.rs: CODECS needs an entry whose name begins with \"{codec}\""
        );
    }
}

fn indicator(preset: &str) -> Box<dyn Codec> {
    Box::new(Of {
        decoder: ascii::Decoder::new(ascii::Preset::named(preset).unwrap().format()),
        push: |decoder, bytes| shown(decoder.push(bytes)),
        losses: |decoder| decoder.counts().bad_lines,
    })
}

/// CANopen on top of slcan: what frames mean, and a node's start that listens to them all.
struct Canopen {
    frames: slcan::HostDecoder,
    startup: NodeStartup,
}

impl Canopen {
    fn new() -> Self {
        Self { frames: slcan::HostDecoder::default(), startup: NodeStartup::new(NodeId::new(1).unwrap()).0 }
    }

    fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut events = Vec::new();
        for message in self.frames.push(bytes) {
            let slcan::AdapterMessage::Frame { frame, .. } = message else { continue };
            let progress = self.startup.on_frame(&frame);
            events.push(format!("{:?} {progress:?}", Message::from_frame(&frame)));
        }
        events
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
