//! Server side of SDO, for simulated nodes: one transfer at a time, as CiA 301 demands of one SDO channel.

use super::message::*;
use crate::can::CanFrame;
use crate::canopen::network::{CobId, NodeId, frame};
use crate::canopen::objects::ObjectKey;

/// The objects of a node.
pub trait ObjectDictionary {
    /// The bytes of an object, numbers little-endian.
    fn read(&mut self, key: ObjectKey) -> Result<Vec<u8>, AbortCode>;
    /// Writes an object; the bytes may have any length.
    fn write(&mut self, key: ObjectKey, data: &[u8]) -> Result<(), AbortCode>;
}

/// Answers the SDO requests to one node.
#[derive(Debug, Clone)]
pub struct SdoServer {
    node: NodeId,
    transfer: Option<Transfer>,
}

#[derive(Debug, Clone)]
struct Transfer {
    key: ObjectKey,
    toggle: bool,
    direction: Direction,
}

#[derive(Debug, Clone)]
enum Direction {
    Giving { data: Vec<u8>, given: usize },
    Taking { data: Vec<u8>, announced: Option<usize> },
}

impl SdoServer {
    /// A server for this node.
    pub fn new(node: NodeId) -> Self {
        Self { node, transfer: None }
    }

    /// Takes a frame from the bus and gives the answer, if the frame was a request to this node.
    pub fn on_frame(&mut self, received: &CanFrame, objects: &mut impl ObjectDictionary) -> Option<CanFrame> {
        if received.id() != CobId::SdoRequest(self.node).can_id() || received.is_remote() {
            return None;
        }
        let request = <&[u8; 8]>::try_from(received.data()).ok()?;
        let answer = match request[0] >> 5 {
            0 => self.take_segment(request, objects),
            1 => self.begin_download(request, objects),
            2 => self.begin_upload(request, objects),
            3 => self.give_segment(request),
            4 => {
                self.transfer = None; // the client gave up; an abort has no answer
                return None;
            }
            _ => Err(AbortCode::COMMAND),
        };
        let bytes = answer.unwrap_or_else(|code| {
            let begun = self.transfer.take().map(|transfer| transfer.key);
            abort_frame(begun.unwrap_or(key_of(request)), code)
        });
        Some(frame(CobId::SdoAnswer(self.node), &bytes))
    }

    fn begin_upload(
        &mut self,
        request: &[u8; 8],
        objects: &mut impl ObjectDictionary,
    ) -> Result<[u8; 8], AbortCode> {
        self.transfer = None;
        let key = key_of(request);
        let data = objects.read(key)?;
        if (1..=4).contains(&data.len()) {
            let mut bytes = [0; 4];
            bytes[..data.len()].copy_from_slice(&data);
            let unused = 4 - data.len() as u8;
            return Ok(object_frame(0x40 | EXPEDITED | SIZE_GIVEN | unused << 2, key, bytes));
        }
        let size = (data.len() as u32).to_le_bytes();
        let direction = Direction::Giving { data, given: 0 };
        self.transfer = Some(Transfer { key, toggle: false, direction });
        Ok(object_frame(0x40 | SIZE_GIVEN, key, size))
    }

    fn give_segment(&mut self, request: &[u8; 8]) -> Result<[u8; 8], AbortCode> {
        let Some(Transfer { toggle, direction: Direction::Giving { data, given }, .. }) = &mut self.transfer
        else {
            return Err(AbortCode::COMMAND);
        };
        if toggle_of(request[0]) != *toggle {
            return Err(AbortCode::TOGGLE);
        }
        let end = data.len().min(*given + 7);
        let last = end == data.len();
        let segment = segment_frame(*toggle, &data[*given..end], last);
        (*given, *toggle) = (end, !*toggle);
        if last {
            self.transfer = None;
        }
        Ok(segment)
    }

    fn begin_download(
        &mut self,
        request: &[u8; 8],
        objects: &mut impl ObjectDictionary,
    ) -> Result<[u8; 8], AbortCode> {
        self.transfer = None;
        let key = key_of(request);
        let size_given = request[0] & SIZE_GIVEN != 0;
        if request[0] & EXPEDITED != 0 {
            let unused = if size_given { usize::from(request[0] >> 2 & 0b11) } else { 0 };
            objects.write(key, &request[4..8 - unused])?;
        } else {
            let announced = size_given.then(|| number_of(request) as usize);
            if announced.is_some_and(|bytes| bytes > MAX_OBJECT_BYTES) {
                return Err(AbortCode::MEMORY);
            }
            let direction = Direction::Taking { data: Vec::new(), announced };
            self.transfer = Some(Transfer { key, toggle: false, direction });
        }
        Ok(object_frame(0x60, key, [0; 4]))
    }

    fn take_segment(
        &mut self,
        request: &[u8; 8],
        objects: &mut impl ObjectDictionary,
    ) -> Result<[u8; 8], AbortCode> {
        let Some(Transfer { key, toggle, direction: Direction::Taking { data, announced } }) =
            &mut self.transfer
        else {
            return Err(AbortCode::COMMAND);
        };
        if toggle_of(request[0]) != *toggle {
            return Err(AbortCode::TOGGLE);
        }
        let (chunk, last) = segment_of(request);
        data.extend_from_slice(chunk);
        if data.len() > announced.unwrap_or(MAX_OBJECT_BYTES)
            || last && announced.is_some_and(|n| n != data.len())
        {
            return Err(AbortCode::LENGTH);
        }
        let mut answer = [0; 8];
        answer[0] = 0x20 | toggle_bit(*toggle);
        *toggle = !*toggle;
        if last {
            objects.write(*key, data)?;
            self.transfer = None;
        }
        Ok(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;
    use crate::canopen::sdo::{SdoProgress, SdoTransfer};
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    #[derive(Default)]
    struct Table(BTreeMap<ObjectKey, Vec<u8>>);

    impl ObjectDictionary for Table {
        fn read(&mut self, key: ObjectKey) -> Result<Vec<u8>, AbortCode> {
            self.0.get(&key).cloned().ok_or(AbortCode::NO_OBJECT)
        }

        fn write(&mut self, key: ObjectKey, data: &[u8]) -> Result<(), AbortCode> {
            self.0.insert(key, data.to_vec());
            Ok(())
        }
    }

    fn run(start: (SdoTransfer, CanFrame), server: &mut SdoServer, objects: &mut Table) -> SdoProgress {
        let (mut transfer, mut request) = start;
        loop {
            let answer = server.on_frame(&request, objects).expect("a request has an answer");
            match transfer.on_frame(&answer) {
                SdoProgress::Send(next) => request = next,
                end => return end,
            }
        }
    }

    #[test]
    fn a_segment_nobody_began_is_refused() {
        let node = NodeId::new(5).unwrap();
        let mut server = SdoServer::new(node);
        let stray = CanFrame::data_frame(CanId::Standard(0x605), &[0x60, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        let answer = server.on_frame(&stray, &mut Table::default()).unwrap();
        assert_eq!(answer.data()[4..], AbortCode::COMMAND.0.to_le_bytes());
        let abort = SdoTransfer::upload(node, ObjectKey::new(0x1000, 0)).0.give_up();
        assert_eq!(server.on_frame(&abort, &mut Table::default()), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn what_is_written_is_read_back_whatever_its_length(
            data in prop::collection::vec(any::<u8>(), 0..80), id in 1u8..=127, index in any::<u16>(), sub in any::<u8>(),
        ) {
            let (node, key) = (NodeId::new(id).unwrap(), ObjectKey::new(index, sub));
            let (mut server, mut objects) = (SdoServer::new(node), Table::default());
            let missing = run(SdoTransfer::upload(node, key), &mut server, &mut objects);
            let error = SdoError::Aborted { key, code: AbortCode::NO_OBJECT };
            prop_assert_eq!(missing, SdoProgress::Failed { error, abort: None });
            let written = run(SdoTransfer::download(node, key, &data), &mut server, &mut objects);
            prop_assert_eq!(written, SdoProgress::Done(vec![]));
            let read = run(SdoTransfer::upload(node, key), &mut server, &mut objects);
            prop_assert_eq!(read, SdoProgress::Done(data));
        }

        #[test]
        fn no_frames_make_either_side_panic(
            frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=8), 0..40), writing in any::<bool>(),
        ) {
            let (node, key) = (NodeId::new(1).unwrap(), ObjectKey::new(0x2000, 0));
            let mut server = SdoServer::new(node);
            let mut objects = Table::default();
            objects.0.insert(key, vec![7; 30]);
            let mut transfer =
                if writing { SdoTransfer::download(node, key, &[1; 20]).0 } else { SdoTransfer::upload(node, key).0 };
            for data in frames {
                server.on_frame(&CanFrame::data_frame(CanId::Standard(0x601), &data).unwrap(), &mut objects);
                transfer.on_frame(&CanFrame::data_frame(CanId::Standard(0x581), &data).unwrap());
            }
        }
    }
}
