//! Client side of one SDO transfer. Frames go in and out through the caller, who also watches the time: when an answer stays
//! out, send [`SdoTransfer::give_up`] and begin another transfer.
//!
//! An answer says which object or which segment it is of. One of another was late or came twice: it is of a request before
//! and changes nothing.

use super::message::*;
use crate::can::CanFrame;
use crate::canopen::network::{CobId, NodeId, frame};
use crate::canopen::objects::ObjectKey;

/// Command specifiers of answers: 0 and 1 of segments, 2 and 3 of the beginning (CiA 301 §7.2.4.3); above are aborts and blocks.
const LAST_ANSWER: u8 = 3;

/// One reading or writing of one object.
#[derive(Debug, Clone)]
pub struct SdoTransfer {
    node: NodeId,
    key: ObjectKey,
    state: State,
}

#[derive(Debug, Clone)]
enum State {
    UploadAsked,
    Uploading { toggle: bool, announced: Option<usize>, data: Vec<u8> },
    DownloadAsked { data: Vec<u8>, segmented: bool },
    Downloading { toggle: bool, data: Vec<u8>, sent: usize },
    Over,
}

/// What a frame did to a transfer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SdoProgress {
    /// The frame is no SDO answer of this node.
    NotMine,
    /// Send this and wait for the next answer.
    Send(CanFrame),
    /// Finished: the bytes read (little-endian numbers), empty after writing.
    Done(Vec<u8>),
    /// Failed; if there is a frame, send it so that the node gives up too.
    Failed {
        /// Why.
        error: SdoError,
        /// Abort for the node.
        abort: Option<CanFrame>,
    },
}

impl SdoTransfer {
    /// Begins to read an object; send the frame.
    pub fn upload(node: NodeId, key: ObjectKey) -> (Self, CanFrame) {
        let request = frame(CobId::SdoRequest(node), &object_frame(0x40, key, [0; 4]));
        (Self { node, key, state: State::UploadAsked }, request)
    }

    /// Begins to write an object; send the frame. One to four bytes go expedited, others segmented.
    pub fn download(node: NodeId, key: ObjectKey, data: &[u8]) -> (Self, CanFrame) {
        let segmented = !(1..=4).contains(&data.len());
        let request = if segmented {
            object_frame(0x20 | SIZE_GIVEN, key, (data.len() as u32).to_le_bytes())
        } else {
            let mut bytes = [0; 4];
            bytes[..data.len()].copy_from_slice(data);
            object_frame(0x20 | EXPEDITED | SIZE_GIVEN | (4 - data.len() as u8) << 2, key, bytes)
        };
        let state = State::DownloadAsked { data: data.to_vec(), segmented };
        (Self { node, key, state }, frame(CobId::SdoRequest(node), &request))
    }

    /// The object of the transfer.
    pub fn key(&self) -> ObjectKey {
        self.key
    }

    /// Ends a transfer whose answer stays out; send the frame.
    pub fn give_up(self) -> CanFrame {
        self.request(abort_frame(self.key, AbortCode::TIMEOUT))
    }

    /// Takes a frame from the bus.
    pub fn on_frame(&mut self, received: &CanFrame) -> SdoProgress {
        if received.id() != CobId::SdoAnswer(self.node).can_id() || received.is_remote() {
            return SdoProgress::NotMine;
        }
        let Ok(answer) = <&[u8; 8]>::try_from(received.data()) else {
            let command = received.data().first().copied().unwrap_or(0);
            return self.fail(self.out_of_place(command, received.dlc()), AbortCode::COMMAND);
        };
        if answer[0] == ABORT {
            return self.aborted(answer);
        }
        match std::mem::replace(&mut self.state, State::Over) {
            State::UploadAsked if answer[0] >> 5 == 2 && key_of(answer) == self.key => {
                self.begin_upload(answer)
            }
            State::Uploading { toggle, announced, data }
                if answer[0] >> 5 == 0 && toggle_of(answer[0]) == toggle =>
            {
                self.take_segment(answer, toggle, announced, data)
            }
            State::DownloadAsked { data, segmented } if answer[0] >> 5 == 3 && key_of(answer) == self.key => {
                if segmented {
                    self.send_segment(false, data, 0)
                } else {
                    SdoProgress::Done(Vec::new())
                }
            }
            State::Downloading { toggle, data, sent }
                if answer[0] >> 5 == 1 && toggle_of(answer[0]) == toggle =>
            {
                if sent == data.len() {
                    return SdoProgress::Done(Vec::new());
                }
                self.send_segment(!toggle, data, sent)
            }
            State::Over => SdoProgress::NotMine,
            waiting if answer[0] >> 5 <= LAST_ANSWER => {
                self.state = waiting;
                SdoProgress::NotMine
            }
            _ => self.fail(self.out_of_place(answer[0], 8), AbortCode::COMMAND),
        }
    }

    fn aborted(&mut self, answer: &[u8; 8]) -> SdoProgress {
        // Some nodes name no object.
        let of = key_of(answer);
        if matches!(self.state, State::Over) || of != self.key && of != ObjectKey::new(0, 0) {
            return SdoProgress::NotMine;
        }
        self.state = State::Over;
        let error = SdoError::Aborted { key: self.key, code: AbortCode(number_of(answer)) };
        SdoProgress::Failed { error, abort: None }
    }

    fn begin_upload(&mut self, answer: &[u8; 8]) -> SdoProgress {
        let size_given = answer[0] & SIZE_GIVEN != 0;
        if answer[0] & EXPEDITED != 0 {
            let unused = if size_given { usize::from(answer[0] >> 2 & 0b11) } else { 0 };
            return SdoProgress::Done(answer[4..8 - unused].to_vec());
        }
        let announced = size_given.then(|| number_of(answer) as usize);
        if announced.is_some_and(|bytes| bytes > MAX_OBJECT_BYTES) {
            return self.fail(SdoError::TooLong(self.key), AbortCode::MEMORY);
        }
        self.state = State::Uploading { toggle: false, announced, data: Vec::new() };
        self.ask_segment(false)
    }

    fn take_segment(
        &mut self,
        answer: &[u8; 8],
        toggle: bool,
        announced: Option<usize>,
        mut data: Vec<u8>,
    ) -> SdoProgress {
        let (chunk, last) = segment_of(answer);
        data.extend_from_slice(chunk);
        if data.len() > announced.unwrap_or(MAX_OBJECT_BYTES)
            || last && announced.is_some_and(|n| n != data.len())
        {
            let error = match announced {
                Some(announced) => SdoError::Length { key: self.key, announced, got: data.len() },
                None => SdoError::TooLong(self.key),
            };
            return self.fail_after(error, last);
        }
        if last {
            return SdoProgress::Done(data);
        }
        self.state = State::Uploading { toggle: !toggle, announced, data };
        self.ask_segment(!toggle)
    }

    fn ask_segment(&self, toggle: bool) -> SdoProgress {
        let mut request = [0; 8];
        request[0] = 0x60 | toggle_bit(toggle);
        SdoProgress::Send(self.request(request))
    }

    fn send_segment(&mut self, toggle: bool, data: Vec<u8>, sent: usize) -> SdoProgress {
        let end = data.len().min(sent + 7);
        let segment = segment_frame(toggle, &data[sent..end], end == data.len());
        self.state = State::Downloading { toggle, data, sent: end };
        SdoProgress::Send(self.request(segment))
    }

    fn out_of_place(&self, command: u8, length: usize) -> SdoError {
        SdoError::OutOfPlace { key: self.key, command, length }
    }

    fn fail(&mut self, error: SdoError, code: AbortCode) -> SdoProgress {
        self.state = State::Over;
        SdoProgress::Failed { error, abort: Some(self.request(abort_frame(self.key, code))) }
    }

    /// The node's side is over after its last segment: no abort then.
    fn fail_after(&mut self, error: SdoError, node_is_done: bool) -> SdoProgress {
        if node_is_done {
            self.state = State::Over;
            return SdoProgress::Failed { error, abort: None };
        }
        self.fail(error, AbortCode::LENGTH)
    }

    fn request(&self, bytes: [u8; 8]) -> CanFrame {
        frame(CobId::SdoRequest(self.node), &bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;

    fn node() -> NodeId {
        NodeId::new(1).unwrap()
    }

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect()
    }

    fn answer(hex: &str) -> CanFrame {
        CanFrame::data_frame(CanId::Standard(0x581), &bytes(hex)).unwrap()
    }

    /// Plays a recorded dialogue: requests must be the recorded ones, answers are fed.
    fn play(start: (SdoTransfer, CanFrame), dialogue: &[(&str, &str)]) -> SdoProgress {
        let (mut transfer, mut request) = start;
        for (position, (expected, reply)) in dialogue.iter().enumerate() {
            assert_eq!(request.data(), bytes(expected), "request {position}");
            match transfer.on_frame(&answer(reply)) {
                SdoProgress::Send(next) => request = next,
                end => return end,
            }
        }
        panic!("the dialogue ended before the transfer")
    }

    /// Recorded on the bus between python canopen 2.4.1 master and LocalNode, node 1.
    #[test]
    fn dialogues_recorded_with_an_independent_stack_are_reproduced() {
        let upload = |index, sub| SdoTransfer::upload(node(), ObjectKey::new(index, sub));
        assert_eq!(
            play(upload(0x1000, 0), &[("4000100000000000", "4300100094010200")]),
            SdoProgress::Done(vec![0x94, 0x01, 0x02, 0x00])
        );
        assert_eq!(
            play(upload(0x1A00, 0), &[("40001A0000000000", "4F001A0002000000")]),
            SdoProgress::Done(vec![2])
        );
        let name = [
            ("4008100000000000", "4108100018000000"),
            ("6000000000000000", "00522D7465737420"),
            ("7000000000000000", "1070726F62652031"),
            ("6000000000000000", "0020284369412034"),
            ("7000000000000000", "1930342900000000"),
        ];
        assert_eq!(play(upload(0x1008, 0), &name), SdoProgress::Done(b"R-test probe 1 (CiA 404)".to_vec()));
        let note = [
            ("2100200016000000", "6000200000000000"),
            ("0061206E6577206E", "2000000000000000"),
            ("10616D65206F6620", "3000000000000000"),
            ("00746865206E6F64", "2000000000000000"),
            ("1D65000000000000", "3000000000000000"),
        ];
        let download = SdoTransfer::download(node(), ObjectKey::new(0x2000, 0), b"a new name of the node");
        assert_eq!(play(download, &note), SdoProgress::Done(vec![]));
        let heartbeat = SdoTransfer::download(node(), ObjectKey::new(0x1017, 0), &50u16.to_le_bytes());
        assert_eq!(play(heartbeat, &[("2B17100032000000", "6017100000000000")]), SdoProgress::Done(vec![]));
        let missing = ObjectKey::new(0x5FFF, 0);
        assert_eq!(
            play(upload(0x5FFF, 0), &[("40FF5F0000000000", "80FF5F0000000206")]),
            SdoProgress::Failed {
                error: SdoError::Aborted { key: missing, code: AbortCode::NO_OBJECT },
                abort: None
            }
        );
    }

    #[test]
    fn answers_of_requests_before_change_nothing() {
        let key = ObjectKey::new(0x1008, 0);
        let (begin, first, last) = ("4108100009000000", "00522D7465737420", "1B31320000000000");
        let foreign = ["4F001A0002000000", "8018100400000206", "6017100000000000"];
        let (mut transfer, _) = SdoTransfer::upload(node(), key);
        for stale in foreign.into_iter().chain([first, last]) {
            assert_eq!(
                transfer.on_frame(&answer(stale)),
                SdoProgress::NotMine,
                "{stale} before the beginning"
            );
        }
        assert!(matches!(transfer.on_frame(&answer(begin)), SdoProgress::Send(_)));
        for stale in foreign.into_iter().chain([begin, last]) {
            assert_eq!(
                transfer.on_frame(&answer(stale)),
                SdoProgress::NotMine,
                "{stale} before the first segment"
            );
        }
        assert!(matches!(transfer.on_frame(&answer(first)), SdoProgress::Send(_)));
        assert_eq!(transfer.on_frame(&answer(first)), SdoProgress::NotMine);
        assert_eq!(transfer.on_frame(&answer(last)), SdoProgress::Done(b"R-test 12".to_vec()));
    }

    #[test]
    fn a_short_answer_and_one_that_is_too_long_end_the_transfer() {
        let key = ObjectKey::new(0x1008, 0);
        let check = |text: &str, expected: SdoError, code: u32| {
            let (mut transfer, _) = SdoTransfer::upload(node(), key);
            let SdoProgress::Failed { error, abort: Some(abort) } = transfer.on_frame(&answer(text)) else {
                panic!("{text} ends nothing")
            };
            assert_eq!(error, expected);
            assert_eq!(abort.data()[4..], code.to_le_bytes());
            assert_eq!(transfer.on_frame(&answer("00522D7465737420")), SdoProgress::NotMine);
        };
        check("41081000", SdoError::OutOfPlace { key, command: 0x41, length: 4 }, 0x0504_0001);
        check("41081000FFFFFFFF", SdoError::TooLong(key), 0x0504_0005);
    }
}
