//! Axis words of a block: only axes whose written position changes.

use super::program::Target;
use trunnion_core::{AxisValues, Joint};

/// Remembers what was written last.
pub(super) struct Words {
    decimals: usize,
    written: AxisValues<Option<String>>,
    numbers: AxisValues<f64>,
}

/// What a block has to say.
pub(super) struct Changed {
    /// Letters and numbers in the order X Y Z A B C.
    pub words: Vec<(Joint, String)>,
    /// Length of the way in mm and degrees together, from the written numbers; axes whose place was unknown do not count.
    pub length: f64,
}

impl Words {
    pub(super) fn new(decimals: usize) -> Self {
        Self { decimals, written: AxisValues::default(), numbers: AxisValues::default() }
    }

    /// The axes that are written again.
    pub(super) fn changed(&mut self, to: &Target) -> Changed {
        let mut changed = Changed { words: Vec::new(), length: 0.0 };
        for &(letter, value) in to {
            let text = fixed(value, self.decimals);
            if self.written[letter].as_ref() == Some(&text) {
                continue;
            }
            if self.written[letter].is_some() {
                changed.length = changed.length.hypot(value - self.numbers[letter]);
            }
            self.written[letter] = Some(text.clone());
            self.numbers[letter] = value;
            changed.words.push((letter, text));
        }
        changed
    }
}

/// Straight moves of controllers with inverse time: G94 and G93 are written when the mode changes, F in every block.
pub(super) struct Moves {
    words: Words,
    /// G01 or G1.
    straight: &'static str,
    /// Decimals of F in 1/min.
    inverse_decimals: usize,
    inverse_time: bool,
    /// Words before the next move.
    before: &'static str,
}

impl Moves {
    pub(super) fn new(decimals: usize, straight: &'static str, inverse_decimals: usize) -> Self {
        Self { words: Words::new(decimals), straight, inverse_decimals, inverse_time: false, before: "" }
    }

    /// Words of the next move, before all others.
    pub(super) fn begins_with(&mut self, words: &'static str) {
        self.before = words;
    }

    /// Words of the linear axes where they stand.
    pub(super) fn linear(&self) -> String {
        let word = |letter: Joint| Some(format!(" {letter}{}", self.words.written[letter].as_ref()?));
        Joint::LINEAR.into_iter().filter_map(word).collect()
    }

    /// To `to` at a feed; nothing when it is there.
    pub(super) fn feed(&mut self, to: &Target, per_min: f64) -> String {
        let feed = short(per_min, 3);
        self.block(to, &feed, false, "G94 ")
    }

    /// To `to` in so many seconds; nothing when it is there.
    pub(super) fn timed(&mut self, to: &Target, seconds: f64) -> String {
        let inverse = short(60.0 / seconds, self.inverse_decimals);
        self.block(to, &inverse, true, "G93 ")
    }

    /// Back to feed per minute, where the mode is another.
    pub(super) fn end(&self) -> &'static str {
        if self.inverse_time { "G94\n" } else { "" }
    }

    fn block(&mut self, to: &Target, f: &str, inverse_time: bool, mode: &str) -> String {
        let word = |(letter, number): &(Joint, String)| format!(" {letter}{number}");
        let axes: String = self.words.changed(to).words.iter().map(word).collect();
        if axes.is_empty() {
            return axes;
        }
        let mode = if self.inverse_time == inverse_time { "" } else { mode };
        self.inverse_time = inverse_time;
        let before = std::mem::take(&mut self.before);
        format!("{before}{mode}{}{axes} F{f}\n", self.straight)
    }
}

/// A number with this many decimals, never "-0".
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let nothing = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if nothing { text.trim_start_matches('-').into() } else { text }
}

/// A number without superfluous zeros, but with a decimal point.
pub(super) fn short(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    let trimmed = text.trim_end_matches('0');
    if trimmed.ends_with('.') { format!("{trimmed}0") } else { trimmed.into() }
}

/// Text that every control shows: printable ASCII, without what would end a comment.
pub(super) fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '(' | '[' | '{' => out.push('['),
            ')' | ']' | '}' => out.push(']'),
            '°' => out += " deg",
            'µ' => out.push('u'),
            '–' | '—' | '−' => out.push('-'),
            '"' | '\'' => out.push(' '),
            ';' => out.push(','),
            c if c.is_ascii_graphic() || c == ' ' => out.push(c),
            _ => out.push('?'),
        }
    }
    out
}

/// Lines of at most `width` characters, broken at blanks.
pub(super) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is always a line");
        if !line.is_empty() && line.len() + 1 + word.len() > width {
            lines.push(word.into());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

/// A name of letters, digits and underscores.
pub(super) fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect()
}
