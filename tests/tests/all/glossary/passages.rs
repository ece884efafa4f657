//! Text that users read, word by word, of source, documents and configuration.

/// Words shown on either side of what is found.
const CONTEXT: usize = 7;

/// Words of the longest sentence (docs/glossary.md).
const LONGEST: usize = 25;

/// A literal, a paragraph, a cell or a run of comments.
pub struct Passage {
    pub words: Vec<Word>,
    /// It can be the head of a column.
    pub is_head: bool,
}

pub struct Word {
    line: usize,
    /// With its punctuation.
    text: String,
    /// Without it, in lower case.
    bare: String,
}

impl Passage {
    /// Words of `text`, each with its line.
    pub fn new(lines: &[(usize, &str)]) -> Self {
        let words = lines.iter().flat_map(|&(line, text)| {
            text.split_whitespace().map(move |word| {
                let bare = word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
                Word { line, text: word.to_string(), bare }
            })
        });
        Self { words: words.collect(), is_head: false }
    }

    pub fn line(&self, at: usize) -> usize {
        self.words[at].line
    }

    pub fn is(&self, pattern: &str) -> bool {
        self.words.iter().map(|word| word.bare.as_str()).eq(pattern.split(' '))
    }

    /// Where the words of `pattern` follow one another in one sentence, and how many they are.
    pub fn find(&self, pattern: &str) -> Vec<(usize, usize)> {
        let parts: Vec<&str> = pattern.split(' ').collect();
        let fits = |words: &[Word]| {
            let last = words.len() - 1;
            words.iter().zip(&parts).enumerate().all(|(i, (word, part))| {
                let bare = match part.strip_suffix('*') {
                    Some(stem) => word.bare.starts_with(stem),
                    None => word.bare == *part,
                };
                bare && (i == last || !word.text.ends_with(['.', ',', ';', ':', '?', '!', ')']))
            })
        };
        let windows = self.words.windows(parts.len()).enumerate();
        windows.filter(|(_, words)| fits(words)).map(|(at, _)| (at, parts.len())).collect()
    }

    /// Sentences of more than [`LONGEST`] words: line, number of words, text. What follows a colon is a
    /// sentence of its own, as is what follows an empty line.
    pub fn long_sentences(&self) -> Vec<(usize, usize, String)> {
        let goes_on = |word: &Word, next: &Word| {
            let is_item = next.text == "-" || next.text == "```";
            !word.text.ends_with(['.', ';', ':', '?', '!']) && next.line <= word.line + 1 && !is_item
        };
        let counted = |sentence: &[Word]| sentence.iter().filter(|word| !word.bare.is_empty()).count();
        let text =
            |sentence: &[Word]| sentence.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(" ");
        self.words
            .chunk_by(goes_on)
            .filter(|sentence| counted(sentence) > LONGEST)
            .map(|sentence| (sentence[0].line, counted(sentence), text(sentence)))
            .collect()
    }

    /// Words `at..at + length` and those around them.
    pub fn around(&self, at: usize, length: usize) -> String {
        let end = self.words.len().min(at + length + CONTEXT);
        let words = &self.words[at.saturating_sub(CONTEXT)..end];
        words.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(" ")
    }
}

/// Paragraphs and cells.
pub fn of_markdown(text: &str) -> Vec<Passage> {
    let mut passages = Vec::new();
    let mut paragraph: Vec<(usize, &str)> = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    for (i, line) in lines.iter().enumerate() {
        let line = line.trim();
        let is_row = line.starts_with('|');
        let starts = is_row || line.is_empty() || line.starts_with(['#', '-']);
        if starts && !paragraph.is_empty() {
            passages.push(Passage::new(&std::mem::take(&mut paragraph)));
        }
        if is_row {
            let is_head = lines.get(i + 1).is_some_and(|next| next.trim().starts_with("|--"));
            let cells = line.split('|').map(|cell| Passage { is_head, ..Passage::new(&[(i + 1, cell)]) });
            passages.extend(cells);
        } else if !line.is_empty() {
            paragraph.push((i + 1, line));
        }
    }
    passages.push(Passage::new(&paragraph));
    passages
}

/// Comments, those of neighbouring lines together.
pub fn of_toml(text: &str) -> Vec<Passage> {
    let mut passages = Vec::new();
    let mut comment: Vec<(usize, &str)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut quoted = false;
        let at = line.find(|c| {
            quoted ^= c == '"';
            c == '#' && !quoted
        });
        match at {
            Some(at) => comment.push((i + 1, &line[at + 1..])),
            None => passages.push(Passage::new(&std::mem::take(&mut comment))),
        }
    }
    passages.push(Passage::new(&comment));
    passages
}

/// The descriptions of a JSON schema, one a line as the tests write it; names of keys are no text.
pub fn of_schema(text: &str) -> Vec<Passage> {
    let described = |(i, line): (usize, &str)| {
        let text = line.trim().strip_prefix("\"description\": ")?;
        Some(Passage::new(&[(i + 1, text.trim_end_matches(',').trim_matches('"'))]))
    };
    text.lines().enumerate().filter_map(described).collect()
}

/// String literals outside comments, attributes and test modules, and doc comments that clap prints. Names of JSON objects are no
/// text: their schemas hold them.
pub fn of_rust(text: &str) -> Vec<Passage> {
    let mut source = Source { rest: text, line: 1 };
    let mut passages = Vec::new();
    let has_help = text.contains("clap");
    while !source.rest.is_empty() {
        if source.rest.starts_with("#[cfg(test)]") {
            source.skip_item();
        } else if has_help && source.rest.starts_with("///") {
            passages.push(Passage::new(&source.help()));
        } else if let Some(text) = source.token()
            && !source.rest.trim_start().starts_with(':')
        {
            let text: Vec<(usize, &str)> = text.iter().map(|(line, text)| (*line, text.as_str())).collect();
            passages.push(Passage { is_head: true, ..Passage::new(&text) });
        }
    }
    passages
}

/// Names in the code, tests included, as words: `told_apart` is "told apart".
pub fn names_of_rust(text: &str) -> Vec<Passage> {
    let mut source = Source { rest: text, line: 1 };
    let mut names = Vec::new();
    while let Some(first) = source.rest.chars().next() {
        if (first.is_alphabetic() || first == '_') && raw_hashes(source.rest).is_none() {
            let line = source.line;
            let name = source.word();
            let mut words = String::new();
            for (at, letter) in name.char_indices() {
                let is_capital = letter.is_uppercase() && !name[..at].ends_with(char::is_uppercase);
                if letter == '_' || is_capital {
                    words.push(' ');
                }
                words.extend(Some(letter).filter(|letter| *letter != '_'));
            }
            names.push(Passage::new(&[(line, &words)]));
        } else {
            source.token();
        }
    }
    names
}

/// What is not yet read.
struct Source<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Source<'a> {
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes.min(self.rest.len()));
        self.line += taken.matches('\n').count();
        self.rest = rest;
        taken
    }

    /// Through the first `end`.
    fn through(&mut self, end: &str) -> &'a str {
        let bytes = self.rest.find(end).map_or(self.rest.len(), |at| at + end.len());
        self.take(bytes)
    }

    /// An item with its attributes, through its `;` or its closing brace.
    fn skip_item(&mut self) {
        let mut depth = 0_usize;
        while let Some(c) = self.rest.chars().next() {
            self.token();
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && matches!(c, '}' | ';') {
                return;
            }
        }
    }

    /// Neighbouring lines of a doc comment.
    fn help(&mut self) -> Vec<(usize, &'a str)> {
        let mut lines = Vec::new();
        while let Some(comment) = self.rest.trim_start().strip_prefix("///") {
            self.take(self.rest.len() - comment.len());
            lines.push((self.line, self.through("\n")));
        }
        lines
    }

    /// One comment, attribute, literal, word or character; the lines of a string literal.
    fn token(&mut self) -> Option<Vec<(usize, String)>> {
        let rest = self.rest;
        if rest.starts_with("//") {
            self.through("\n");
        } else if rest.starts_with("/*") {
            self.through("*/");
        } else if rest.starts_with("#[") || rest.starts_with("#![") {
            self.attribute();
        } else if let Some(hashes) = raw_hashes(rest) {
            self.through("\"");
            let line = self.line;
            let close = format!("\"{}", "#".repeat(hashes));
            let text = self.through(&close);
            return Some(lines(line, text.strip_suffix(&close).unwrap_or(text)));
        } else if rest.starts_with('"') {
            return Some(self.string());
        } else if rest.starts_with('\'') {
            self.character();
        } else if self.word().is_empty() {
            self.take(rest.chars().next().map_or(1, char::len_utf8));
        }
        None
    }

    /// A name, a keyword or a number.
    fn word(&mut self) -> &'a str {
        let end = self.rest.find(|c: char| !c.is_alphanumeric() && c != '_');
        self.take(end.unwrap_or(self.rest.len()))
    }

    fn attribute(&mut self) {
        self.through("[");
        let mut depth = 1_usize;
        while let Some(c) = self.rest.chars().next().filter(|_| depth > 0) {
            self.token();
            match c {
                '[' => depth += 1,
                ']' => depth -= 1,
                _ => {}
            }
        }
    }

    /// `'a'`, `'\n'`, or the quote of a lifetime.
    fn character(&mut self) {
        let mut chars = self.rest.char_indices().skip(1);
        match (chars.next(), chars.next()) {
            (Some((_, '\\')), _) => {
                self.take(3);
                self.through("'");
            }
            (_, Some((at, '\''))) => _ = self.take(at + 1),
            _ => _ = self.take(1),
        }
    }

    fn string(&mut self) -> Vec<(usize, String)> {
        self.take(1);
        let mut text = vec![(self.line, String::new())];
        while let Some(c) = self.rest.chars().next() {
            let taken = self.take(if c == '\\' { 2 } else { c.len_utf8() });
            match taken {
                "\"" => break,
                // A continued line.
                "\\\n" => {
                    let spaces = self.rest.find(|c: char| !c.is_whitespace()).unwrap_or(0);
                    self.take(spaces);
                    text.push((self.line, String::new()));
                }
                "\n" | "\\n" => text.push((self.line, String::new())),
                "{" => {
                    let end =
                        self.rest.find(['}', ' ', '"']).filter(|end| self.rest[*end..].starts_with('}'));
                    let last = &mut text.last_mut().unwrap().1;
                    last.push('{');
                    if let Some(end) = end {
                        self.take(end);
                    }
                }
                "\\\"" => text.last_mut().unwrap().1.push('"'),
                _ => text.last_mut().unwrap().1.push_str(taken),
            }
        }
        text
    }
}

/// Number of `#` of a raw string that starts here.
fn raw_hashes(rest: &str) -> Option<usize> {
    let opened = ["r", "br", "cr"].iter().find_map(|prefix| rest.strip_prefix(prefix))?;
    let hashes = opened.len() - opened.trim_start_matches('#').len();
    opened[hashes..].starts_with('"').then_some(hashes)
}

fn lines(first: usize, text: &str) -> Vec<(usize, String)> {
    text.lines().enumerate().map(|(i, line)| (first + i, line.to_string())).collect()
}
