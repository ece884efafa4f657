//! Strings and templates of a script: what the page shows.

use super::passages::Passage;
use std::iter::Peekable;
use std::str::Chars;

/// Every string and template outside comments, also those within the parts of a template that are computed.
pub fn of_javascript(text: &str) -> Vec<Passage> {
    let mut script = Script { rest: text.chars().peekable(), line: 1, passages: Vec::new() };
    script.code(None);
    script.passages
}

/// What is not yet read, and what was found.
struct Script<'a> {
    rest: Peekable<Chars<'a>>,
    line: usize,
    passages: Vec<Passage>,
}

impl Script<'_> {
    fn next(&mut self) -> Option<char> {
        let next = self.rest.next();
        self.line += usize::from(next == Some('\n'));
        next
    }

    /// Through the brace that closes a part of a template, or to the end.
    fn code(&mut self, closed_by: Option<char>) {
        let mut depth = 0_usize;
        while let Some(c) = self.next() {
            match c {
                '"' | '`' => self.literal(c),
                '/' if self.rest.peek() == Some(&'/') => while self.next().is_some_and(|c| c != '\n') {},
                '/' if self.rest.peek() == Some(&'*') => self.comment(),
                '{' => depth += 1,
                _ if depth == 0 && Some(c) == closed_by => return,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
    }

    fn comment(&mut self) {
        while let Some(c) = self.next() {
            if c == '*' && self.rest.peek() == Some(&'/') {
                self.next();
                return;
            }
        }
    }

    fn literal(&mut self, quote: char) {
        let mut lines = vec![(self.line, String::new())];
        while let Some(c) = self.next().filter(|c| *c != quote) {
            match c {
                '\\' => _ = self.next(),
                '\n' => lines.push((self.line, String::new())),
                '$' if quote == '`' && self.rest.peek() == Some(&'{') => {
                    self.next();
                    self.code(Some('}'));
                    lines.last_mut().unwrap().1.push_str("{}");
                }
                _ => lines.last_mut().unwrap().1.push(c),
            }
        }
        let lines: Vec<(usize, &str)> = lines.iter().map(|(line, text)| (*line, text.as_str())).collect();
        self.passages.push(Passage { is_head: true, ..Passage::new(&lines) });
    }
}
