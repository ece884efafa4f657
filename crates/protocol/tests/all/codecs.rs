//! Every codec that takes a byte stream, as its harnesses see it: the property tests of `fuzz`, and the fuzzer in `tests/fuzz`, which
//! takes this file in by its path.

use std::fmt::Debug;
use trunnion_protocol::canopen::network::Message;
use trunnion_protocol::canopen::{NodeId, NodeStartup};
use trunnion_protocol::{ascii, keyence, linuxcncrsh, mtconnect, optoncdt, slcan};

/// A codec as the harness sees it: bytes in, events as text out, and what was lost.
pub trait Codec {
    /// What becomes of these bytes.
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

/// One codec.
pub struct Entry {
    /// Its name, which begins with that of its module.
    pub name: &'static str,
    /// One that has seen nothing.
    pub new: fn() -> Box<dyn Codec>,
    /// One good frame; alone it gives one event.
    pub frame: fn() -> Vec<u8>,
    /// Good frames that garbage may take with it.
    pub takes_along: usize,
}

/// All of them.
pub const CODECS: &[Entry] = &[
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
