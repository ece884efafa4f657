//! A page in another language: texts of finished markup are looked up in one table ([`table`]), whole or as a pattern.
//!
//! Headings, heads of tables, labels, units in words and verdicts have an entry; a test of the pages names one that has none.
//! So have all that the catalogue says and all that `check` says of the known mistakes, each with a test. Other sentences of the engine stay
//! English where they have none. Numbers keep the decimal point (ISO 80000-1 allows it), names and ids stay as they are.

mod table;

use crate::markup::escape;
use table::entries;

/// What a text holds in place of what it says about one machine.
const HOLE: &str = "{}";
/// What a screen reader says of an element.
const LABEL: &str = " aria-label=\"";
/// Before these stands a number, in which no name or clause is.
const SIZES: [&str; 2] = [" µm", " mm"];

/// The language of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// As everything is written.
    #[default]
    English,
    /// German.
    German,
    /// Japanese.
    Japanese,
}

impl Language {
    /// Every language with its code [ISO 639].
    pub const NAMES: [(&str, Self); 3] =
        [("en", Self::English), ("de", Self::German), ("ja", Self::Japanese)];

    /// Its code.
    pub fn code(self) -> &'static str {
        Self::NAMES.into_iter().find(|(_, language)| *language == self).map_or("en", |(code, _)| code)
    }

    /// What its characters are called, and two that fonts of Latin letters lack; `None` where they have all.
    pub fn of_other_fonts(self) -> Option<(&'static str, [char; 2])> {
        (self == Self::Japanese).then_some(("Japanese", ['機', '測']))
    }

    /// A text of this program; `None` where the table has none.
    pub fn say(self, english: &str) -> Option<String> {
        if self == Self::English {
            return Some(english.into());
        }
        self.whole(english)
            .or_else(|| self.by_sentences(english))
            .or_else(|| self.by_items(english))
            .or_else(|| self.by_label(english))
            .or_else(|| self.by_alternatives(english))
            .or_else(|| self.by_pattern(english))
            .or_else(|| self.by_parts(english))
            .or_else(|| self.by_axes(english))
    }

    fn whole(self, english: &str) -> Option<String> {
        entries().find(|entry| entry[0] == english).map(|entry| entry[self as usize].to_string())
    }

    /// What stands between items of a list, between labels in a row, and after a label.
    fn marks(self) -> [&'static str; 3] {
        if self == Self::Japanese { ["；", "、", "："] } else { ["; ", ", ", ":"] }
    }

    /// What stands between sentences.
    fn space(self) -> &'static str {
        if self == Self::Japanese { "" } else { " " }
    }

    /// A list whose items all have an entry. Before the patterns: that of one item would hold the others in its last hole.
    fn by_items(self, english: &str) -> Option<String> {
        // A sentence may have a semicolon of its own.
        if !english.contains("; ") || english.ends_with('.') {
            return None;
        }
        let items: Option<Vec<String>> = english.split("; ").map(|item| self.say(item)).collect();
        Some(items?.join(self.marks()[0]))
    }

    /// A list of which some items have an entry. An English sentence with a semicolon of its own is none.
    fn by_some_items(self, english: &str) -> Option<String> {
        let said: Vec<Option<String>> = english.split("; ").map(|item| self.say(item)).collect();
        said.iter().any(Option::is_some).then(|| {
            let items = english.split("; ").zip(said).map(|(item, said)| said.unwrap_or_else(|| item.into()));
            items.collect::<Vec<_>>().join(self.marks()[0])
        })
    }

    /// Labels in a row, `Y, B 60° and above, both setups:`: each has an entry, or is a name.
    fn by_parts(self, english: &str) -> Option<String> {
        let (row, is_label) = english.strip_suffix(':').map_or((english, false), |row| (row, true));
        if !row.contains(", ") {
            return None;
        }
        let mut known = 0;
        let say = |part: &str| match self.say(part) {
            Some(said) => {
                known += 1;
                Some(said)
            }
            None => is_name(part).then(|| part.to_owned()),
        };
        let parts: Vec<String> = row.split(", ").map(say).collect::<Option<_>>()?;
        let [_, comma, colon] = self.marks();
        // Names alone have no entry where they stand as in English.
        (known > 0 || comma != ", ").then(|| parts.join(comma) + if is_label { colon } else { "" })
    }

    /// An effect with what is said of it, `Backlash of the drive (backlash:X): The axis stops …`: both have an entry.
    fn by_label(self, english: &str) -> Option<String> {
        let (label, text) = english.split_once(": ")?;
        let (label, text) = (self.say(label)?, self.say(text)?);
        let colon = self.marks()[2];
        Some(label + colon + self.space() + &text)
    }

    /// Sentences in a row that all have an entry. Before lists and patterns: those of the first would hold the others in their last hole.
    fn by_sentences(self, english: &str) -> Option<String> {
        let one = |sentence: &str| {
            let whole = self.whole(sentence).or_else(|| self.by_label(sentence));
            whole.or_else(|| self.by_pattern(sentence))
        };
        english.match_indices(". ").find_map(|(at, _)| {
            let (first, others) = (&english[..=at], &english[at + 2..]);
            Some(one(first)? + self.space() + &self.say(others)?)
        })
    }

    /// Alternatives that all have an entry. Before the patterns: that of one would hold the others in its last hole.
    fn by_alternatives(self, english: &str) -> Option<String> {
        // A sentence with a clause of its own is none.
        if english.ends_with('.') {
            return None;
        }
        let or = if self == Self::Japanese { "、または" } else { " oder " };
        english.match_indices(", or ").find_map(|(at, mark)| {
            let (first, others) = (&english[..at], &english[at + mark.len()..]);
            Some(self.say(first)? + or + &self.say(others)?)
        })
    }

    /// Axes in a row, `X, Y and Z`.
    fn by_axes(self, english: &str) -> Option<String> {
        let (others, last) = english.split_once(" and ")?;
        let mut axes = others.split(", ").chain([last]);
        let and = if self == Self::Japanese { "、" } else { " und " };
        let is_axis = |name: &str| name.len() <= 2 && name.starts_with(|c: char| c.is_ascii_uppercase());
        axes.all(is_axis).then(|| others.replace(", ", self.marks()[1]) + and + last)
    }

    fn by_pattern(self, english: &str) -> Option<String> {
        let patterns = entries().filter(|entry| entry[0].contains(HOLE));
        let found = patterns.filter_map(|entry| Some((entry, holes(entry[0], english)?)));
        // The entry that leaves least open says most.
        let (entry, held) =
            found.min_by_key(|(_, held)| held.iter().map(|part| part.len()).sum::<usize>())?;
        let mut text = String::new();
        let mut held = held.into_iter();
        for (i, part) in entry[self as usize].split(HOLE).enumerate() {
            if i > 0 {
                let held = held.next().unwrap_or_default();
                text += &self.say(held).or_else(|| self.by_some_items(held)).unwrap_or_else(|| held.into());
            }
            text += part;
        }
        Some(text)
    }
}

/// The same in every language: a name of one word, or an axis with its position, `X −60 mm`.
fn is_name(part: &str) -> bool {
    let mut words = part.split(' ').skip(1);
    words.next().is_none_or(|word| word.trim_start_matches('−').starts_with(|c: char| c.is_ascii_digit()))
        && part.starts_with(char::is_alphabetic)
}

/// What stands in the holes of a pattern; `None` where the text is not of it.
fn holes<'t>(pattern: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let parts: Vec<&str> = pattern.split(HOLE).collect();
    // A label such as `{} back` holds a name; only a sentence, a list or what has a remark holds one with commas.
    let lists = pattern.contains(['.', ':', ',', '—', '(']);
    held(&parts[1..], text.strip_prefix(parts[0])?, lists)
}

/// What stands before each of the parts of a pattern.
fn held<'t>(parts: &[&str], rest: &'t str, lists: bool) -> Option<Vec<&'t str>> {
    let (part, others) = parts.split_first()?;
    let is_size = SIZES.iter().any(|unit| part.starts_with(unit));
    let fits = |hole: &str| {
        !hole.is_empty()
            && (lists || !hole.contains(", "))
            && (!is_size || !hole.contains(char::is_alphabetic))
    };
    if others.is_empty() {
        return rest.strip_suffix(part).filter(|hole| fits(hole)).map(|hole| vec![hole]);
    }
    let ends = rest.match_indices(part).filter(|(at, _)| fits(&rest[..*at]));
    ends.map(|(at, part)| (&rest[..at], &rest[at + part.len()..]))
        .find_map(|(hole, rest)| Some([vec![hole], held(others, rest, lists)?].concat()))
}

/// Well-formed markup with its texts, and what is read out in their place, in another language; tags and other attributes stay as they are.
pub(crate) fn translated(markup: &str, language: Language) -> String {
    if language == Language::English {
        return markup.into();
    }
    let mut out = String::with_capacity(markup.len() + markup.len() / 4);
    for piece in markup.split_inclusive('>') {
        let (text, tag) = piece.split_at(piece.find('<').unwrap_or(piece.len()));
        let plain = unescaped(text.trim());
        match language.say(&plain).filter(|_| !plain.is_empty()) {
            Some(said) => out += &text.replacen(text.trim(), &escape(&said), 1),
            None => out += text,
        }
        out += &labelled(tag, language).unwrap_or_else(|| tag.into());
    }
    out
}

/// A tag with its label in another language; `None` where it has none, or the table has no entry.
fn labelled(tag: &str, language: Language) -> Option<String> {
    let (before, label) = tag.split_once(LABEL)?;
    let (label, after) = label.split_once('"')?;
    let said = escape(&language.say(&unescaped(label))?);
    Some(format!("{before}{LABEL}{said}\"{after}"))
}

/// Undoes [`escape`].
fn unescaped(text: &str) -> String {
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_string(), |text, (entity, c)| text.replace(entity, c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_entry_lacks_a_language_or_a_hole() {
        for entry in entries() {
            assert!(entry.iter().all(|text| !text.trim().is_empty()), "{entry:?}");
            let count = |text: &str| text.matches(HOLE).count();
            assert!(entry.iter().all(|text| count(text) == count(entry[0])), "{entry:?}");
            assert_eq!(entries().filter(|other| other[0] == entry[0]).count(), 1, "twice: {entry:?}");
        }
    }

    #[test]
    fn texts_are_translated_and_tags_names_and_numbers_are_not() {
        let markup = "<th class=\"parameter\">parameter</th><td>EX0C &lt;1 µm</td>\n<h2>Place 3: X</h2>";
        let german = translated(markup, Language::German);
        assert_eq!(
            german,
            "<th class=\"parameter\">Parameter</th><td>EX0C &lt;1 µm</td>\n<h2>Stelle 3: X</h2>"
        );
        assert_eq!(translated(markup, Language::English), markup);
    }

    #[test]
    fn a_list_has_the_marks_of_its_language_and_each_item_its_own_pattern() {
        let list = "Location errors without a number of their own: place of axis B along Y; zero of C.";
        let place = "setup high, X 160 mm, Y −150 mm";
        for (language, said) in [
            (
                Language::German,
                [
                    "Lageabweichungen ohne eigene Zahl: Ort der Achse B entlang Y; Nullpunkt von C.",
                    "Aufstellung high, X 160 mm, Y −150 mm",
                ],
            ),
            (
                Language::Japanese,
                [
                    "単独では値の求まらない位置誤差：軸 B の位置（Y 方向）；C の原点。",
                    "段取り high、X 160 mm、Y −150 mm",
                ],
            ),
        ] {
            assert_eq!([list, place].map(|text| language.say(text)), said.map(|text| Some(text.to_string())));
        }
        let english = "Likely cause: Wear; nothing else.";
        assert_eq!(Language::Japanese.say(english).as_deref(), Some("推定される原因：Wear; nothing else."));
        let effect = "Sag of the tilting frame or head under its own weight (gravity-sag:B)";
        assert_eq!(
            Language::German.say(effect).as_deref(),
            Some("Durchbiegung des Schwenkrahmens oder Schwenkkopfs unter Eigengewicht (gravity-sag:B)")
        );
    }

    #[test]
    fn a_pattern_holds_what_stands_between_its_words() {
        assert_eq!(holes("{} of {} points", "3 of 4 points"), Some(vec!["3", "4"]));
        assert_eq!(holes("{} of {} points", "3 of 4 readings"), None);
        assert_eq!(holes("setup {}", "setup "), None);
        assert_eq!(holes("{} back", "+2 µm with C forward, −2 µm with C back"), None);
    }
}
