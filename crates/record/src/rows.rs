//! Rows of separated text, with where each cell stands. Comma-separated with decimal points, or as spreadsheets in much of
//! Europe write it: semicolons (or tabs) with decimal commas. Lines that begin with `#` are remarks; rows without any text, which
//! spreadsheets leave, are none. A first line `sep=;` names the separator, for spreadsheets.

use csv_core::{ReadFieldResult, Reader, ReaderBuilder};

/// A cell: the column in characters, from 1, at which its text begins, and the text without spaces around it.
pub type Cell = (usize, String);

/// A row that is not empty.
#[derive(Default)]
pub struct Row {
    /// Line of the file, from 1.
    pub line: usize,
    /// Its cells.
    pub cells: Vec<Cell>,
    /// Places of cells that are numbers with a point, in a table with decimal commas: the point may mark thousands.
    pub pointed: Vec<usize>,
}

/// The rows of a text, one after the other; a byte-order mark is passed over, and so are remarks and empty rows.
pub fn rows(text: &str) -> Rows<'_> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let named = named_separator(text);
    let (begins, line) = named.map_or((0, 1), |(_, length)| (length, 2));
    let separator = named.map_or_else(|| separator(text), |(separator, _)| separator);
    let reader = ReaderBuilder::new().delimiter(separator).comment(Some(REMARK as u8)).build();
    let decimal_comma = separator != b',';
    let has_commas = decimal_comma && has_decimal_commas(&text[begins..]);
    let cell = vec![0; FIRST_CELL];
    Rows { text, reader, decimal_comma, has_commas, cell, begins, at: begins, line, ended: false }
}

/// The separator that a first line `sep=;` names, and the length of that line.
fn named_separator(text: &str) -> Option<(u8, usize)> {
    let line = text.split_inclusive('\n').next()?;
    let named = line.trim().trim_matches('"').to_ascii_lowercase();
    match named.strip_prefix("sep=")?.as_bytes() {
        [separator] => Some((*separator, line.len())),
        // Blanks at the end of a line are no text: a tab.
        [] if line.trim_end_matches(['\r', '\n', '"']).ends_with('\t') => Some((b'\t', line.len())),
        _ => None,
    }
}

/// Whether a comma stands between two digits somewhere, where cells are separated by something else.
fn has_decimal_commas(text: &str) -> bool {
    text.as_bytes()
        .windows(3)
        .any(|three| three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit())
}

/// Begins a line that is no row.
const REMARK: char = '#';

/// What separates the cells of the header, which holds names alone.
fn separator(text: &str) -> u8 {
    let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with(REMARK)).unwrap_or("");
    let others = [b';', b'\t'].into_iter().find(|other| header.bytes().any(|byte| byte == *other));
    others.filter(|_| !header.contains(',')).unwrap_or(b',')
}

/// Room for a cell at first, bytes; it grows when a longer one comes.
const FIRST_CELL: usize = 256;

/// See [`rows`].
pub struct Rows<'a> {
    text: &'a str,
    reader: Reader,
    decimal_comma: bool,
    /// It has decimal commas, so that a point in a number is no decimal mark.
    has_commas: bool,
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
            if row.cells.iter().any(|(_, cell)| !cell.is_empty()) {
                return Some(row);
            }
        }
    }
}

impl Rows<'_> {
    fn row(&mut self) -> Option<Row> {
        let (mut row, mut length, mut column) = (Row { line: self.line, ..Row::default() }, 0, 1);
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
            // Line ends of rows that were empty, and remarks, are read with the cell behind them.
            let raw = &self.text[self.begins..self.at];
            let cell = if row.cells.is_empty() { behind_remarks(raw) } else { raw };
            self.line += line_ends(&raw[..raw.len() - cell.len()]);
            if row.cells.is_empty() {
                row.line = self.line;
            }
            let text = bare(&String::from_utf8_lossy(&self.cell[..length]));
            if self.has_commas && text.contains('.') && text.parse::<f64>().is_ok() {
                row.pointed.push(row.cells.len());
            }
            row.cells
                .push((column + leading(cell), if self.decimal_comma { with_point(text) } else { text }));
            self.line += line_ends(cell);
            (self.begins, length, column) = (self.at, 0, column + cell.chars().count());
            if record_end {
                return Some(row);
            }
        }
        None
    }
}

/// What follows empty lines and remarks.
fn behind_remarks(mut raw: &str) -> &str {
    loop {
        raw = raw.trim_start_matches(['\r', '\n']);
        match raw.strip_prefix(REMARK) {
            Some(remark) => raw = remark.split_once('\n').map_or("", |(_, behind)| behind),
            None => return raw,
        }
    }
}

/// A number with a decimal comma as one with a point; any other text as it is.
fn with_point(text: String) -> String {
    let number = text.replacen(',', ".", 1);
    if text.contains(',') && number.parse::<f64>().is_ok() { number } else { text }
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
    fn a_point_between_decimal_commas_is_no_decimal_mark() {
        let check = |text: &str, expected: &[usize]| {
            assert_eq!(rows(text).last().unwrap().pointed, expected, "{text:?}");
        };
        check("a;b\n1,5;2\n1.021;2,5", &[0]);
        check("a;b\n1.5;2\n1.021;2.5", &[]);
        check("a,b\n1.5,2\n1.021,2.5", &[]);
        check("a;b\n1,5;2\n12.03.2024;v1.5", &[]);
    }

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
        check("# by hand, twice\na,b\n#\n1,2", &[(2, &[(1, "a"), (3, "b")]), (4, &[(1, "1"), (3, "2")])]);
        check("a;b\r\n1,5;x,y\r\n", &[(1, &[(1, "a"), (3, "b")]), (2, &[(1, "1.5"), (5, "x,y")])]);
        check("sep=;\r\na;b\r\n1,5;2\r\n;\r\n", &[(2, &[(1, "a"), (3, "b")]), (3, &[(1, "1.5"), (5, "2")])]);
        check("a\tb\n-1,5\t\"2,25\"", &[(1, &[(1, "a"), (3, "b")]), (2, &[(1, "-1.5"), (6, "2.25")])]);
    }
}
