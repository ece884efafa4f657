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

/// The rows of a text; a byte-order mark is passed over.
pub fn rows(text: &str) -> Vec<Row> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = Reader::new();
    // No cell is longer than the text.
    let mut buffer = vec![0; text.len() + 1];
    let (mut rows, mut row) = (Vec::new(), Row { line: 1, cells: Vec::new() });
    let (mut begins, mut at, mut length, mut line, mut column) = (0, 0, 0, 1, 1);
    loop {
        let (result, read, written) = reader.read_field(&text.as_bytes()[at..], &mut buffer[length..]);
        (at, length) = (at + read, length + written);
        let record_end = match result {
            ReadFieldResult::InputEmpty | ReadFieldResult::OutputFull => continue,
            ReadFieldResult::Field { record_end } => record_end,
            ReadFieldResult::End => break,
        };
        // Line ends of rows that were empty are read with the cell behind them.
        let raw = &text[begins..at];
        let cell = if row.cells.is_empty() { raw.trim_start_matches(['\r', '\n']) } else { raw };
        line += line_ends(&raw[..raw.len() - cell.len()]);
        if row.cells.is_empty() {
            row.line = line;
        }
        row.cells.push((column + leading(cell), bare(&String::from_utf8_lossy(&buffer[..length]))));
        line += line_ends(cell);
        (begins, length, column) = (at, 0, column + cell.chars().count());
        if record_end {
            column = 1;
            let next = Row { line, cells: Vec::new() };
            rows.push(std::mem::replace(&mut row, next));
        }
    }
    rows.retain(|row: &Row| row.cells.len() > 1 || row.cells.iter().any(|(_, cell)| !cell.is_empty()));
    rows
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
            let found = rows(text);
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
