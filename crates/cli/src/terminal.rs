//! The one way text reaches the screen: wrapped to the terminal, long lists folded, and no panic when the reader has gone
//! (`| head`).

mod fold;

use anyhow::Context;
use fold::fold;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm};

/// Columns and lines where nobody says how many there are (a pipe, a file).
const USUAL: Screen = Screen { columns: 80, lines: 40 };
/// Fewer than these are taken for a slip of the terminal.
const FEWEST: Screen = Screen { columns: 40, lines: 10 };

/// True after `--all`: lists are not folded.
static ALL: AtomicBool = AtomicBool::new(false);

/// Size of a screen, characters.
#[derive(Clone, Copy)]
struct Screen {
    columns: usize,
    lines: usize,
}

impl Screen {
    /// The terminal's size, else that of `COLUMNS` and `LINES`, else the usual one.
    fn now(is_terminal: bool) -> Self {
        let terminal = terminal_size::terminal_size().filter(|_| is_terminal);
        let of_environment = |name: &str| std::env::var(name).ok()?.parse().ok();
        let columns = terminal.map(|(width, _)| width.0.into()).or_else(|| of_environment("COLUMNS"));
        let lines = terminal.map(|(_, height)| height.0.into()).or_else(|| of_environment("LINES"));
        Self {
            columns: columns.unwrap_or(USUAL.columns).max(FEWEST.columns),
            lines: lines.unwrap_or(USUAL.lines).max(FEWEST.lines),
        }
    }

    /// The text as the screen shows it.
    fn shown(self, text: &str) -> String {
        let height = |line: &str| wrap(line, self.columns).lines().count().max(1);
        match ALL.load(Ordering::Relaxed) {
            true => wrap(text, self.columns),
            false => wrap(&fold(text, self.lines, &height), self.columns),
        }
    }
}

/// From now on lists are printed in full, however long they are.
pub fn show_all() {
    ALL.store(true, Ordering::Relaxed);
}

/// Prints a result. A reader that closed the pipe is no failure.
pub fn print(text: &str) -> anyhow::Result<()> {
    print_verbatim(&Screen::now(std::io::stdout().is_terminal()).shown(text))
}

/// Prints what other programs read, as it is: a table, a program, a file.
pub fn print_verbatim(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    gone_is_fine(out.write_all(text.as_bytes()).and_then(|()| out.flush())).context("writing the result")
}

/// Draws a screen over the one before it where there is a terminal; prints `line` where there is none.
pub fn redraw(screen: &str, line: &str) -> anyhow::Result<()> {
    if !std::io::stdout().is_terminal() {
        return print_verbatim(line);
    }
    // ECMA-48: cursor home; erase to the end of each line, and below the last one.
    let lines = Screen::now(true).shown(screen).replace('\n', "\x1b[K\n");
    print_verbatim(&format!("\x1b[H{lines}\x1b[J"))
}

/// Prints an answer of many as JSON on one line.
pub fn print_json_line(answer: &impl serde::Serialize) -> anyhow::Result<()> {
    print_verbatim(&trunnion::results::to_json_line(answer).context("writing the result as JSON")?)
}

/// Prints JSON, indented, with a final newline; neither wrapped nor folded.
pub fn print_json(answer: &impl serde::Serialize) -> anyhow::Result<()> {
    print_verbatim(&trunnion::results::to_json(answer).context("writing the result as JSON")?)
}

/// Prints a remark or an error, `trunnion: …`, on standard error. Nobody is left to read it when that fails.
pub fn remark(text: &str) {
    let mut out = std::io::stderr().lock();
    let text = Screen::now(out.is_terminal()).shown(&format!("trunnion: {text}\n"));
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).ok();
}

fn gone_is_fine(written: std::io::Result<()>) -> std::io::Result<()> {
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Lines of at most `width` columns, broken at blanks alone: an id, a flag or a path stays whole. What continues a line of a table hangs
/// under its last column, or begins in the middle where that is further left; what continues a sentence hangs under its beginning.
fn wrap(text: &str, width: usize) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
        if textwrap::core::display_width(line) <= width {
            out += line;
        } else {
            let begins = line.len() - line.trim_start().len();
            let hanging = " ".repeat(last_column(line, width).unwrap_or(begins));
            let options = Options::new(width)
                .initial_indent(&line[..begins])
                .subsequent_indent(&hanging)
                .wrap_algorithm(WrapAlgorithm::FirstFit)
                .word_separator(WordSeparator::AsciiSpace)
                .word_splitter(WordSplitter::NoHyphenation)
                .break_words(false);
            out += &textwrap::wrap(&line[begins..], options).join("\n");
        }
        out += end;
    }
    out
}

/// Where the last column of a table begins, if this is a line of one, but no further than the middle.
fn last_column(line: &str, width: usize) -> Option<usize> {
    let gap = line.trim_end().rfind("  ")? + 2;
    let at = textwrap::core::display_width(&line[..gap]);
    (!line[..gap].trim().is_empty()).then_some(at.min(width / 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sentences_and_tables_continue_where_they_belong() {
        let sentence = "  The error is largest where axis B stands beyond sixty degrees.\n";
        assert_eq!(
            wrap(sentence, 40),
            "  The error is largest where axis B\n  stands beyond sixty degrees.\n"
        );
        let row = "EY0B   not observable   zero by the convention of the datum\n";
        let half = " ".repeat(20);
        assert_eq!(
            wrap(row, 40),
            format!("EY0B   not observable   zero by the\n{half}convention of the\n{half}datum\n")
        );
        let row = "EX0C   4.1 um   contains EX0A and nothing else\n";
        assert_eq!(wrap(row, 40), "EX0C   4.1 um   contains EX0A and\n                nothing else\n");
    }

    #[test]
    fn ids_and_flags_stay_whole() {
        let sentence = "Missing from the model is gravity-sag:B, as --although-inadequate says.\n";
        assert_eq!(
            wrap(sentence, 40),
            "Missing from the model is gravity-sag:B,\nas --although-inadequate says.\n"
        );
        assert_eq!(wrap(sentence, 39).lines().next(), Some("Missing from the model is"));
    }

    proptest! {
        #[test]
        fn no_line_is_too_long_and_no_word_is_lost(
            words in proptest::collection::vec("[a-zµ°:-]{1,12}", 1..60), indent in 0_usize..6,
        ) {
            let text = format!("{}{}\n", " ".repeat(indent), words.join(" "));
            let wrapped = wrap(&text, 40);
            prop_assert!(wrapped.lines().all(|line| textwrap::core::display_width(line) <= 40));
            prop_assert_eq!(wrapped.split_whitespace().collect::<Vec<_>>(), words);
        }
    }
}
