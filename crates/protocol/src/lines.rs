//! Text lines out of a byte stream: what every ASCII protocol of indicators and boxes has in common.
//!
//! A line ends with CR, LF or both; empty lines mean nothing. A byte that is no text spoils its line. What a line
//! means is decided by the codec that owns the splitter; a line that means nothing to it is counted as bad.

/// Longer than any line of the protocols that use this.
const MAX_LINE: usize = 256;

/// What was seen and what was lost since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Lines that meant something.
    pub lines: u64,
    /// Lines that meant nothing.
    pub bad_lines: u64,
    /// Bytes in those lines.
    pub dropped_bytes: u64,
    /// Times a bad line came after a good one.
    pub resyncs: u64,
}

/// Splits bytes into lines.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    line: Vec<u8>,
    /// Bytes beyond the longest line, counted and not kept.
    overflow: u64,
    spoilt: bool,
    in_step: bool,
    counts: LineCounts,
}

impl Lines {
    /// Takes one byte; gives what `parse` makes of the line it ends.
    pub fn push<T>(&mut self, byte: u8, parse: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        match byte {
            b'\r' | b'\n' => self.end(parse),
            _ => {
                self.spoilt |= !matches!(byte, b' '..=b'~' | b'\t');
                if self.line.len() < MAX_LINE {
                    self.line.push(byte)
                } else {
                    self.overflow += 1
                }
                None
            }
        }
    }

    /// Forgets a line half received, as when a new reply is announced; its bytes are counted.
    pub fn restart(&mut self) {
        if !self.line.is_empty() {
            self.drop_line();
        }
    }

    /// A line has begun and not ended.
    pub fn is_half(&self) -> bool {
        !self.line.is_empty()
    }

    /// The line half received means nothing, however it goes on; it is counted at its end.
    pub fn spoil(&mut self) {
        self.spoilt |= self.is_half();
    }

    /// What was seen and lost.
    pub fn counts(&self) -> LineCounts {
        self.counts
    }

    fn end<T>(&mut self, parse: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        if self.line.is_empty() {
            return None;
        }
        let whole = !self.spoilt && self.overflow == 0;
        let text = std::str::from_utf8(&self.line).ok().filter(|_| whole);
        let Some(meaning) = text.and_then(parse) else {
            self.drop_line();
            return None;
        };
        self.counts.lines += 1;
        self.in_step = true;
        self.line.clear();
        Some(meaning)
    }

    fn drop_line(&mut self) {
        self.counts.bad_lines += 1;
        self.counts.dropped_bytes += self.line.len() as u64 + self.overflow;
        self.counts.resyncs += u64::from(std::mem::replace(&mut self.in_step, false));
        self.line.clear();
        (self.overflow, self.spoilt) = (0, false);
    }
}
