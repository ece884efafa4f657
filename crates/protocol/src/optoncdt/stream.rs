//! The byte stream: blocks of 18-bit values, and replies to commands between them.
//!
//! Garbage is skipped up to the next byte `00xxxxxx`. A block touched by garbage is not given out. While a reply is
//! awaited, text bytes belong to the reply; at any other time they are garbage.

/// One transmitted value, 18 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RawValue(u32);

impl RawValue {
    /// The largest value, 2¹⁸ − 1.
    pub const MAX: RawValue = RawValue(0x3_FFFF);

    /// The value, if it fits 18 bits.
    pub fn new(value: u32) -> Option<Self> {
        (value <= Self::MAX.0).then_some(Self(value))
    }

    /// The number, 0..=262 143.
    pub fn get(self) -> u32 {
        self.0
    }
}

/// The values of one measurement, in the order that `GETOUTINFO_RS422` reports; the first is the distance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// One to [`MAX_VALUES`] values.
    pub values: Vec<RawValue>,
}

/// No sensor of the family sends more values in a block.
pub const MAX_VALUES: usize = 32;

/// When a block is complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockLength {
    /// When the next one begins: right for any setting, but late by one measuring period.
    UntilNext,
    /// After this many values: at once, for a setting known from `GETOUTINFO_RS422`.
    Exactly(usize),
}

/// What the stream contained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// One measurement.
    Block(Block),
    /// The text up to the prompt `->`, which ends every reply; parse it with [`super::Reply::parse`].
    ReplyText(String),
}

/// What was seen and what was lost since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StreamCounts {
    /// Complete values L M H.
    pub values: u64,
    /// Blocks given out.
    pub blocks: u64,
    /// Times the order L M H was lost.
    pub resyncs: u64,
    /// Bytes that belonged neither to a value nor to an awaited reply.
    pub dropped_bytes: u64,
    /// Blocks not given out: garbage inside, too short, too long, or joined in the middle.
    pub damaged_blocks: u64,
}

/// Splits the stream into blocks and replies.
#[derive(Debug, Clone)]
pub struct Decoder {
    length: BlockLength,
    /// L, or L and M, of a value not yet complete.
    partial: Vec<u8>,
    in_step: bool,
    block: Vec<RawValue>,
    state: BlockState,
    reply: Option<String>,
    counts: StreamCounts,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlockState {
    /// Before the first value F = 0, and after a block of known length was given out.
    Between,
    Filling,
    /// Skipping the rest of a block already counted as damaged.
    Damaged,
}

/// A reply longer than this is not a reply (`PRINT`, the longest, is about 2 kB).
const MAX_REPLY: usize = 16 * 1024;

impl Decoder {
    /// A decoder that knows, or does not know, how many values make a block.
    pub fn new(length: BlockLength) -> Self {
        Self {
            length,
            partial: Vec::with_capacity(3),
            in_step: true,
            block: Vec::new(),
            state: BlockState::Between,
            reply: None,
            counts: StreamCounts::default(),
        }
    }

    /// The length of a block from here on; a block half received is given up.
    pub fn set_block_length(&mut self, length: BlockLength) {
        self.length = length;
        self.block.clear();
        self.state = BlockState::Between;
    }

    /// From here on text belongs to a reply, until its prompt has come.
    pub fn await_reply(&mut self) {
        self.reply = Some(String::new());
    }

    /// Gives up waiting for a reply (timeout), with the text received so far.
    pub fn give_up_reply(&mut self) -> Option<String> {
        self.reply.take()
    }

    /// What was seen and lost since the start.
    pub fn counts(&self) -> StreamCounts {
        self.counts
    }

    /// Takes bytes as read and returns what they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Event> {
        let mut events = Vec::new();
        for &byte in bytes {
            self.push_byte(byte, &mut events);
        }
        events
    }

    fn push_byte(&mut self, byte: u8, events: &mut Vec<Event>) {
        if byte == b'>' && self.partial == [b'-'] && self.prompt_may_follow() {
            self.partial.clear();
            events.extend(self.reply.take().map(Event::ReplyText));
            return;
        }
        match (self.partial.as_slice(), byte >> 6) {
            ([], 0b00) | ([_], 0b01) => self.partial.push(byte),
            (&[low, middle], 0b10 | 0b11) => {
                self.partial.clear();
                self.in_step = true;
                let six = |byte: u8| u32::from(byte & 0x3F);
                let value = RawValue(six(low) | six(middle) << 6 | six(byte) << 12);
                self.counts.values += 1;
                self.take_value(value, byte & 0x40 == 0, events);
            }
            _ => {
                for lost in std::mem::take(&mut self.partial) {
                    self.drop_byte(lost);
                }
                if byte >> 6 == 0b00 { self.partial.push(byte) } else { self.drop_byte(byte) }
            }
        }
    }

    /// Text like `ILD1420-` before a value 3Eh must not look like a prompt.
    fn prompt_may_follow(&self) -> bool {
        self.reply.as_ref().is_some_and(|text| !text.ends_with(|c: char| c.is_ascii_alphanumeric()))
    }

    fn drop_byte(&mut self, byte: u8) {
        let text = matches!(byte, b' '..=b'~' | b'\r' | b'\n' | b'\t');
        match &mut self.reply {
            Some(reply) if text && reply.len() < MAX_REPLY => reply.push(char::from(byte)),
            _ => {
                self.counts.dropped_bytes += 1;
                self.counts.resyncs += u64::from(std::mem::replace(&mut self.in_step, false));
                if self.state == BlockState::Filling {
                    self.damage();
                }
            }
        }
    }

    fn take_value(&mut self, value: RawValue, first_of_block: bool, events: &mut Vec<Event>) {
        if first_of_block {
            if self.state == BlockState::Filling {
                match self.length {
                    BlockLength::UntilNext => self.give_out(events),
                    BlockLength::Exactly(_) => self.damage(),
                }
            }
            self.block = vec![value];
            self.state = BlockState::Filling;
        } else {
            match self.state {
                BlockState::Filling if self.block.len() < MAX_VALUES => self.block.push(value),
                BlockState::Filling | BlockState::Between => self.damage(),
                BlockState::Damaged => {}
            }
        }
        if self.state == BlockState::Filling && BlockLength::Exactly(self.block.len()) == self.length {
            self.give_out(events);
        }
    }

    fn give_out(&mut self, events: &mut Vec<Event>) {
        self.counts.blocks += 1;
        self.state = BlockState::Between;
        events.push(Event::Block(Block { values: std::mem::take(&mut self.block) }));
    }

    fn damage(&mut self) {
        self.counts.damaged_blocks += 1;
        self.state = BlockState::Damaged;
        self.block.clear();
    }
}

/// The bytes of one block, as the sensor sends them.
pub fn encode_block(block: &Block) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * block.values.len());
    for (position, RawValue(value)) in block.values.iter().enumerate() {
        let six = |shift: u32| (value >> shift & 0x3F) as u8;
        let further = if position == 0 { 0x00 } else { 0x40 };
        bytes.extend([six(0), 0x40 | six(6), 0x80 | further | six(12)]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn block(values: &[u32]) -> Block {
        Block { values: values.iter().map(|&v| RawValue::new(v).unwrap()).collect() }
    }

    fn blocks(events: Vec<Event>) -> Vec<Block> {
        events.into_iter().filter_map(|e| if let Event::Block(b) = e { Some(b) } else { None }).collect()
    }

    /// Bit layout of the manual, §8.2, written out by hand: 32760 = 000111 111111 111000b.
    #[test]
    fn the_three_bytes_are_those_of_the_manual() {
        let bytes = [0b0011_1000, 0b0111_1111, 0b1000_0111];
        assert_eq!(encode_block(&block(&[32760])), bytes);
        let mut decoder = Decoder::new(BlockLength::Exactly(1));
        assert_eq!(decoder.push(&bytes), [Event::Block(block(&[32760]))]);
    }

    #[test]
    fn a_block_of_unknown_length_ends_where_the_next_begins() {
        let mut decoder = Decoder::new(BlockLength::UntilNext);
        let two = [block(&[1000, 7, 262_143]), block(&[1001, 8, 0])];
        assert_eq!(decoder.push(&encode_block(&two[0])), []);
        assert_eq!(decoder.push(&encode_block(&two[1])), [Event::Block(two[0].clone())]);
    }

    #[test]
    fn joining_in_the_middle_of_a_block_costs_that_block_only() {
        let bytes = [encode_block(&block(&[1, 2, 3])), encode_block(&block(&[4, 5, 6]))].concat();
        let mut decoder = Decoder::new(BlockLength::Exactly(3));
        assert_eq!(blocks(decoder.push(&bytes[4..])), [block(&[4, 5, 6])]);
        let counts = decoder.counts();
        assert_eq!((counts.resyncs, counts.dropped_bytes, counts.damaged_blocks), (1, 2, 1));
    }

    #[test]
    fn a_reply_between_values_is_text_and_the_values_stay() {
        let mut decoder = Decoder::new(BlockLength::Exactly(1));
        decoder.await_reply();
        let (a, b) = (encode_block(&block(&[111])), encode_block(&block(&[222])));
        let bytes = [&a[..], b"OUTPUT RS422\r\n->", &b[..]].concat();
        assert_eq!(
            decoder.push(&bytes),
            [
                Event::Block(block(&[111])),
                Event::ReplyText("OUTPUT RS422\r\n".into()),
                Event::Block(block(&[222]))
            ]
        );
        assert_eq!(decoder.counts().dropped_bytes, 0);
    }

    #[test]
    fn text_nobody_asked_for_is_garbage() {
        let mut decoder = Decoder::new(BlockLength::Exactly(1));
        let bytes = [&b"E210 x\r\n->"[..], &encode_block(&block(&[5]))].concat();
        assert_eq!(blocks(decoder.push(&bytes)), [block(&[5])]);
        assert_eq!((decoder.counts().dropped_bytes, decoder.counts().resyncs), (10, 1));
    }

    fn any_stream() -> impl Strategy<Value = Vec<Block>> {
        let value = (0u32..=0x3_FFFF).prop_map(|v| RawValue::new(v).unwrap());
        (1usize..=4).prop_flat_map(move |n| {
            prop::collection::vec(prop::collection::vec(value.clone(), n), 1..10)
                .prop_map(|blocks| blocks.into_iter().map(|values| Block { values }).collect())
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn blocks_survive_the_wire_however_it_is_split(
            stream in any_stream(),
            cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..8),
        ) {
            let bytes: Vec<u8> = stream.iter().flat_map(encode_block).collect();
            let mut at: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len())).collect();
            at.extend([0, bytes.len()]);
            at.sort_unstable();
            let mut decoder = Decoder::new(BlockLength::Exactly(stream[0].values.len()));
            let decoded: Vec<_> = at.windows(2).flat_map(|w| decoder.push(&bytes[w[0]..w[1]])).collect();
            prop_assert_eq!(blocks(decoded), stream);
            prop_assert_eq!(decoder.counts().dropped_bytes, 0);
        }

        #[test]
        fn any_split_of_any_bytes_gives_the_same_events_and_counts(
            bytes in prop::collection::vec(any::<u8>(), 1..300), cut in any::<prop::sample::Index>(), asked in any::<bool>(),
        ) {
            let mut whole = Decoder::new(BlockLength::UntilNext);
            if asked { whole.await_reply(); }
            let mut split = whole.clone();
            let expected = whole.push(&bytes);
            let (head, tail) = bytes.split_at(cut.index(bytes.len()));
            let got = [split.push(head), split.push(tail)].concat();
            prop_assert_eq!(got, expected);
            prop_assert_eq!(split.counts(), whole.counts());
        }

        #[test]
        fn after_garbage_whole_blocks_are_found_and_every_byte_is_accounted_for(
            garbage in prop::collection::vec(any::<u8>(), 1..200), stream in any_stream(),
        ) {
            let n = stream[0].values.len();
            let mut decoder = Decoder::new(BlockLength::Exactly(n));
            decoder.push(&garbage);
            let bytes: Vec<u8> = stream.iter().flat_map(encode_block).collect();
            // The last two bytes of the garbage may look like L and M, but never take a value with them.
            prop_assert_eq!(blocks(decoder.push(&bytes)), stream);
            let counts = decoder.counts();
            prop_assert_eq!(3 * counts.values + counts.dropped_bytes, (garbage.len() + bytes.len()) as u64);
        }
    }
}
