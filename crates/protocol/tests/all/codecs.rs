//! Every codec that takes a byte stream, as its harnesses see it: the property tests of `fuzz`, and the fuzzer in `tests/fuzz`, which
//! takes this file in by its path.

use std::fmt::Debug;
use trunnion_protocol::canopen::network::Message;
use trunnion_protocol::canopen::{NodeId, NodeStartup, StartupProgress};
use trunnion_protocol::{ascii, keyence, linuxcncrsh, mtconnect, optoncdt, slcan};

/// A codec as the harnesses see it, whatever its events are.
pub trait Codec: Sync {
    /// The events of each piece as text, and what was lost of all of them.
    fn decode(&self, pieces: &[&[u8]]) -> (Vec<Vec<String>>, u64);

    /// Decodes bytes whole and in pieces. Events are compared as they are: to write them as text takes longer than to decode them.
    ///
    /// # Panics
    /// When they differ.
    fn check_split(&self, bytes: &[u8], pieces: &[&[u8]]);
}

/// `new` has seen nothing, `push` takes bytes, `losses` counts bytes or lines that became nothing.
struct Of<D, E> {
    new: fn() -> D,
    push: fn(&mut D, &[u8]) -> Vec<E>,
    losses: fn(&D) -> u64,
}

impl<D, E: Debug + PartialEq> Codec for Of<D, E> {
    fn decode(&self, pieces: &[&[u8]]) -> (Vec<Vec<String>>, u64) {
        let mut decoder = (self.new)();
        let shown = |events: Vec<E>| events.iter().map(|event| format!("{event:?}")).collect();
        let events = pieces.iter().map(|piece| shown((self.push)(&mut decoder, piece))).collect();
        (events, (self.losses)(&decoder))
    }

    fn check_split(&self, bytes: &[u8], pieces: &[&[u8]]) {
        let (mut whole, mut split) = ((self.new)(), (self.new)());
        let expected = (self.push)(&mut whole, bytes);
        let mut rest = &expected[..];
        for piece in pieces {
            let got = (self.push)(&mut split, piece);
            assert!(rest.starts_with(&got), "{got:?} where the whole gave {rest:?}");
            rest = &rest[got.len()..];
        }
        assert!(rest.is_empty(), "only the whole gave {rest:?}");
        assert_eq!((self.losses)(&split), (self.losses)(&whole));
    }
}

/// One codec.
pub struct Entry {
    /// Its name, which begins with that of its module.
    pub name: &'static str,
    /// The codec.
    pub codec: &'static dyn Codec,
    /// One good frame; alone it gives one event.
    pub frame: fn() -> Vec<u8>,
    /// Good frames that garbage may take with it.
    pub takes_along: usize,
}

/// All of them.
pub const CODECS: &[Entry] = &[
    Entry {
        name: "optoncdt",
        codec: &Of {
            new: || optoncdt::Decoder::new(optoncdt::BlockLength::Exactly(2)),
            push: optoncdt::Decoder::push,
            losses: |decoder| decoder.counts().dropped_bytes,
        },
        frame: || {
            let value = |raw| optoncdt::RawValue::new(raw).unwrap();
            optoncdt::encode_block(&optoncdt::Block { values: vec![value(32_760), value(77)] })
        },
        takes_along: 0,
    },
    Entry {
        name: "optoncdt commands",
        codec: &Of {
            new: optoncdt::command::CommandDecoder::default,
            push: optoncdt::command::CommandDecoder::push,
            // A sensor answers a line that is no command with an error: nothing is lost but what is too long.
            losses: |decoder| 1 + decoder.overlong_lines(),
        },
        frame: || optoncdt::Command::get_info().encode(),
        takes_along: 1,
    },
    Entry {
        name: "keyence",
        codec: &Of {
            new: keyence::Decoder::default,
            push: keyence::Decoder::push,
            losses: |decoder| decoder.counts().dropped_bytes,
        },
        frame: || b"M0,+000.5000,-012.3456\r\n".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "keyence commands",
        codec: &Of {
            new: keyence::CommandDecoder::default,
            push: keyence::CommandDecoder::push,
            losses: |decoder| decoder.counts().dropped_bytes,
        },
        frame: || keyence::Command::Read { amplifier: 6, data: 101 }.encode(),
        takes_along: 1,
    },
    Entry {
        name: "ascii, 8 bits",
        codec: &indicator(|| indicator_decoder("mitutoyo-usb")),
        frame: || b"01A+0000.123\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "ascii, 7 bits",
        codec: &indicator(|| indicator_decoder("mahr-c1202")),
        frame: || b"1 +003.25 um <\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "slcan",
        codec: &Of {
            new: slcan::HostDecoder::default,
            push: slcan::HostDecoder::push,
            losses: |decoder| decoder.losses().dropped_bytes,
        },
        frame: || b"t5818430010009401020089F4\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "slcan commands",
        codec: &Of {
            new: slcan::AdapterDecoder::default,
            push: slcan::AdapterDecoder::push,
            losses: |decoder| decoder.losses().dropped_bytes,
        },
        frame: || b"t60184000100000000000\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "canopen",
        codec: &Of { new: Canopen::new, push: Canopen::push, losses: |c| c.frames.losses().dropped_bytes },
        frame: || b"t701105\r".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "linuxcncrsh",
        codec: &Of {
            new: linuxcncrsh::Lines::default,
            push: |decoder, bytes| {
                decoder.push(bytes).into_iter().map(|line| linuxcncrsh::parse_reply(&line)).collect()
            },
            losses: linuxcncrsh::Lines::dropped_bytes,
        },
        frame: || b"JOINT_POS 0 1.5\r\n".to_vec(),
        takes_along: 1,
    },
    Entry {
        name: "mtconnect multipart",
        codec: &Of {
            new: || mtconnect::MultipartDecoder::new("multipart/x-mixed-replace;boundary=xyz").unwrap(),
            push: |decoder, bytes| {
                // The documents inside are read too: any body is a document or an error.
                let read = |part: mtconnect::Part| {
                    let document = mtconnect::parse(&part.body).map_err(|error| error.to_string());
                    (part, document)
                };
                decoder.push(bytes).into_iter().map(read).collect()
            },
            losses: |decoder| decoder.losses().dropped_bytes,
        },
        frame: || mtconnect::encode_part("xyz", "text/xml", b"<MTConnectError/>"),
        takes_along: 3,
    },
];

const fn indicator(new: fn() -> ascii::Decoder) -> Of<ascii::Decoder, ascii::Line> {
    Of { new, push: ascii::Decoder::push, losses: |decoder| decoder.counts().bad_lines }
}

fn indicator_decoder(preset: &str) -> ascii::Decoder {
    ascii::Decoder::new(ascii::Preset::named(preset).unwrap().format())
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

    fn push(&mut self, bytes: &[u8]) -> Vec<(Option<Message>, StartupProgress)> {
        let mut events = Vec::new();
        for message in self.frames.push(bytes) {
            let slcan::AdapterMessage::Frame { frame, .. } = message else { continue };
            let progress = self.startup.on_frame(&frame);
            events.push((Message::from_frame(&frame), progress));
        }
        events
    }
}
