//! Bytes to lines.

/// A longer line is no line of this protocol.
pub const LONGEST_LINE: usize = 4096;

/// Takes bytes, gives lines; what is no text is dropped and counted.
#[derive(Debug, Default)]
pub struct Lines {
    line: Vec<u8>,
    /// The line under way is too long: drop until its end.
    skipping: bool,
    dropped_bytes: u64,
}

impl Lines {
    /// The lines that `bytes` complete, without their ends. Empty lines are left out.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut lines = Vec::new();
        for &byte in bytes {
            if matches!(byte, b'\r' | b'\n') {
                lines.extend(self.end_line());
            } else if self.skipping || self.line.len() == LONGEST_LINE {
                self.dropped_bytes += self.line.len() as u64 + 1;
                self.line.clear();
                self.skipping = true;
            } else {
                self.line.push(byte);
            }
        }
        lines
    }

    /// Bytes that belonged to no line of text.
    pub fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    fn end_line(&mut self) -> Option<String> {
        self.skipping = false;
        let line = std::mem::take(&mut self.line);
        if line.is_empty() {
            return None;
        }
        match String::from_utf8(line) {
            Ok(text) if !text.contains(|c: char| c.is_control() && c != '\t') => Some(text),
            Ok(text) => {
                self.dropped_bytes += text.len() as u64;
                None
            }
            Err(error) => {
                self.dropped_bytes += error.as_bytes().len() as u64;
                None
            }
        }
    }
}
