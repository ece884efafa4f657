//! Rows of comma-separated text, with where each cell stands.

use csv_core::{ReadFieldResult, Reader};

/// A cell: the column in characters, from 1, at which its text begins, and the text without spaces around it.
pub type Cell = (usize, String);

/// A row that is not empty.
pub struct Row {
    /// Line of the file, from 1.
    pub line: usize,
    /// Its cells.
    pub cells: Vec<Cell>,
}

/// The rows of a text, one after the other; a byte-order mark is passed over, and so are empty rows.
pub fn rows(text: &str) -> Rows<'_> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    Rows { text, reader: Reader::new(), cell: vec![0; FIRST_CELL], begins: 0, at: 0, line: 1, ended: false }
}

/// Room for a cell at first, bytes; it grows when a longer one comes.
const FIRST_CELL: usize = 256;

/// See [`rows`].
pub struct Rows<'a> {
    text: &'a str,
    reader: Reader,
    cell: Vec<u8>,
    /// Where the next cell begins, and how far the text is read.
    begins: usize,
    at: usize,
    line: usize,
    ended: bool,
}

impl Iterator for Rows<'_> {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        loop {
            let row = self.row()?;
            if row.cells.len() > 1 || row.cells.iter().any(|(_, cell)| !cell.is_empty()) {
                return Some(row);
            }
        }
    }
}

impl Rows<'_> {
    fn row(&mut self) -> Option<Row> {
        let (mut row, mut length, mut column) = (Row { line: self.line, cells: Vec::new() }, 0, 1);
        while !self.ended {
            let (result, read, written) =
                self.reader.read_field(&self.text.as_bytes()[self.at..], &mut self.cell[length..]);
            (self.at, length) = (self.at + read, length + written);
            let record_end = match result {
                ReadFieldResult::InputEmpty => continue,
                ReadFieldResult::OutputFull => {
                    self.cell.resize(2 * self.cell.len(), 0);
                    continue;
                }
                ReadFieldResult::Field { record_end } => record_end,
                ReadFieldResult::End => {
                    self.ended = true;
                    break;
                }
            };
            // Line ends of rows that were empty are read with the cell behind them.
            let raw = &self.text[self.begins..self.at];
            let cell = if row.cells.is_empty() { raw.trim_start_matches(['\r', '\n']) } else { raw };
            self.line += line_ends(&raw[..raw.len() - cell.len()]);
            if row.cells.is_empty() {
                row.line = self.line;
            }
            row.cells.push((column + leading(cell), bare(&String::from_utf8_lossy(&self.cell[..length]))));
            self.line += line_ends(cell);
            (self.begins, length, column) = (self.at, 0, column + cell.chars().count());
            if record_end {
                return Some(row);
            }
        }
        None
    }
}

fn line_ends(raw: &str) -> usize {
    raw.matches('\n').count()
}

/// Spaces before the text.
fn leading(raw: &str) -> usize {
    raw.trim_end_matches(['\r', '\n']).chars().take_while(|c| c.is_whitespace()).count()
}

/// The text of a cell without spaces and quotation marks around it.
fn bare(cell: &str) -> String {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_says_where_it_stands() {
        let check = |text: &str, expected: &[(usize, &[(usize, &str)])]| {
            let found: Vec<Row> = rows(text).collect();
            let shown: Vec<(usize, Vec<(usize, &str)>)> = found
                .iter()
                .map(|row| (row.line, row.cells.iter().map(|(at, cell)| (*at, cell.as_str())).collect()))
                .collect();
            let expected: Vec<_> = expected.iter().map(|(line, cells)| (*line, cells.to_vec())).collect();
            assert_eq!(shown, expected, "{text:?}");
        };
        check("", &[]);
        check("a,b\n1, 2\n", &[(1, &[(1, "a"), (3, "b")]), (2, &[(1, "1"), (4, "2")])]);
        check("\u{feff}µ,b\r\n\r\n  \r\n1,", &[(1, &[(1, "µ"), (3, "b")]), (4, &[(1, "1"), (3, "")])]);
        check("a\n\n\n\"x, y\", \"z\" ,", &[(1, &[(1, "a")]), (4, &[(1, "x, y"), (9, "z"), (14, "")])]);
        check("a,b", &[(1, &[(1, "a"), (3, "b")])]);
    }
}
