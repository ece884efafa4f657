//! What is kept in memory: the latest.

use std::collections::VecDeque;

/// Bytes at most: four hundred fits of 336 points, a dozen of 10 000.
const MOST_BYTES: usize = 32 << 20;

/// Texts by what they are of, the latest last.
pub(super) struct Shelf(VecDeque<(String, String)>);

impl Shelf {
    pub const EMPTY: Self = Self(VecDeque::new());

    pub fn read(&self, of: &str) -> Option<String> {
        self.0.iter().find(|(known, _)| known == of).map(|(_, text)| text.clone())
    }

    pub fn keep(&mut self, of: &str, text: String) {
        self.0.retain(|(known, _)| known != of);
        self.0.push_back((of.into(), text));
        let mut bytes: usize = self.0.iter().map(|(_, text)| text.len()).sum();
        while bytes > MOST_BYTES
            && let Some((_, oldest)) = self.0.pop_front()
        {
            bytes -= oldest.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_stay_within_the_bound() {
        let mut shelf = Shelf::EMPTY;
        for of in ["a", "b", "c"] {
            shelf.keep(of, "x".repeat(MOST_BYTES / 2));
        }
        assert_eq!(["a", "b", "c"].map(|of| shelf.read(of).is_some()), [false, true, true]);
        shelf.keep("d", "x".repeat(MOST_BYTES + 1));
        assert!(shelf.0.is_empty());
    }
}
