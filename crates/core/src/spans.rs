//! Where the keys and values of a TOML text are.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Places of the keys and values of a text.
pub(crate) struct Spans {
    keys: Vec<Range<usize>>,
    /// Values that hold no others, each with its key.
    pub values: Vec<(String, Range<usize>)>,
}

impl Spans {
    /// Keys and values, in no order.
    pub fn all(&self) -> Vec<Range<usize>> {
        self.keys.iter().cloned().chain(self.values.iter().map(|(_, span)| span.clone())).collect()
    }

    fn table(&mut self, table: &DeTable<'_>) {
        for (key, value) in table {
            self.keys.push(key.span());
            self.value(key.get_ref(), value);
        }
    }

    fn value(&mut self, key: &str, value: &Spanned<DeValue<'_>>) {
        match value.get_ref() {
            DeValue::Table(table) => self.table(table),
            DeValue::Array(items) => items.iter().for_each(|item| self.value(key, item)),
            _ => self.values.push((key.into(), value.span())),
        }
    }
}

/// `None` when the text is no TOML.
pub(crate) fn spans(text: &str) -> Option<Spans> {
    let root = DeTable::parse(text).ok()?;
    let mut spans = Spans { keys: Vec::new(), values: Vec::new() };
    spans.table(root.get_ref());
    Some(spans)
}
