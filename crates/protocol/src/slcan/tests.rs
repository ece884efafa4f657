use super::message::{BEL, CR};
use super::*;
use crate::can::{CanFrame, CanId};
use proptest::prelude::*;

fn standard(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).unwrap()
}

/// SDO upload of 1000h between python canopen 2.4.1 nodes over python-can's slcan, time stamps on.
#[test]
fn the_golden_exchange_decodes() {
    let request = standard(0x601, &[0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0]);
    assert_eq!(HostCommand::Transmit(request).encode(), b"t60184000100000000000\r");
    let answer = standard(0x581, &[0x43, 0x00, 0x10, 0x00, 0x94, 0x01, 0x02, 0x00]);
    assert_eq!(
        HostDecoder::default().push(b"z\rt5818430010009401020089F4\r"),
        [AdapterMessage::Accepted, AdapterMessage::Frame { frame: answer, stamp_ms: Some(0x89F4) }]
    );
}

#[test]
fn commands_have_the_manuals_bytes() {
    let check = |command: HostCommand, expected: &[u8]| {
        assert_eq!(command.encode(), expected);
        assert_eq!(AdapterDecoder::default().push(expected), [Some(command)]);
    };
    check(HostCommand::SetBitrate(Bitrate::K1000), b"S8\r");
    check(HostCommand::Open, b"O\r");
    check(HostCommand::Listen, b"L\r");
    check(HostCommand::Close, b"C\r");
    check(HostCommand::TimeStamps(true), b"Z1\r");
    check(HostCommand::Status, b"F\r");
    // esd CAN-USB-Micro manual, command t
    check(HostCommand::Transmit(standard(0x123, &[0x99, 0x88, 0x77, 0x66])), b"t123499887766\r");
    check(
        HostCommand::Transmit(CanFrame::remote_request(CanId::Extended(0x1ABC_DEF0), 3).unwrap()),
        b"R1ABCDEF03\r",
    );
}

#[test]
fn a_refusal_in_the_middle_of_a_line_is_seen_and_the_piece_counted() {
    let mut decoder = HostDecoder::default();
    assert_eq!(decoder.push(b"t12\x07\r"), [AdapterMessage::Refused, AdapterMessage::Done]);
    assert_eq!(decoder.losses(), Losses { bad_lines: 1, dropped_bytes: 3 });
}

fn any_frame() -> impl Strategy<Value = CanFrame> {
    let id =
        prop_oneof![(0u16..0x800).prop_map(CanId::Standard), (0u32..0x2000_0000).prop_map(CanId::Extended)];
    (id, prop::collection::vec(any::<u8>(), 0..=8), any::<bool>()).prop_map(|(id, data, remote)| {
        if remote {
            CanFrame::remote_request(id, data.len()).unwrap()
        } else {
            CanFrame::data_frame(id, &data).unwrap()
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn frames_survive_the_wire_however_it_is_split(
        frames in prop::collection::vec((any_frame(), prop::option::of(0u16..60_000)), 1..8),
        cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
    ) {
        let messages: Vec<_> =
            frames.into_iter().map(|(frame, stamp_ms)| AdapterMessage::Frame { frame, stamp_ms }).collect();
        let bytes: Vec<u8> = messages.iter().flat_map(AdapterMessage::encode).collect();
        let mut at: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len())).collect();
        at.extend([0, bytes.len()]);
        at.sort_unstable();
        let mut decoder = HostDecoder::default();
        let decoded: Vec<_> = at.windows(2).flat_map(|w| decoder.push(&bytes[w[0]..w[1]])).collect();
        prop_assert_eq!(decoded, messages);
        prop_assert_eq!(decoder.losses(), Losses::default());
    }

    #[test]
    fn after_garbage_the_next_line_is_read_and_the_garbage_counted(
        garbage in prop::collection::vec(any::<u8>().prop_filter("no line end", |b| ![CR, BEL, b'\n'].contains(b)), 100..300),
        frame in any_frame(),
    ) {
        let mut decoder = HostDecoder::default();
        prop_assert_eq!(decoder.push(&garbage), []);
        prop_assert_eq!(decoder.push(b"\r"), []);
        prop_assert_eq!(decoder.losses(), Losses { bad_lines: 1, dropped_bytes: garbage.len() as u64 });
        let message = AdapterMessage::Frame { frame, stamp_ms: None };
        prop_assert_eq!(decoder.push(&message.encode()), [message]);
    }

    #[test]
    fn no_bytes_make_a_decoder_panic(bytes in prop::collection::vec(any::<u8>(), 0..512)) {
        HostDecoder::default().push(&bytes);
        AdapterDecoder::default().push(&bytes);
    }
}
