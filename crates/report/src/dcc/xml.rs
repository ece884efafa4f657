//! Elements of XML; what they hold is markup already.

use crate::markup::escape;

/// `<tag>markup</tag>`.
pub fn holding(tag: &str, markup: &str) -> String {
    format!("<{tag}>{markup}</{tag}>\n")
}

/// The same with attributes, which are escaped.
pub fn with_attributes(tag: &str, attributes: &[(&str, &str)], markup: &str) -> String {
    let attributes: String =
        attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escape(value))).collect();
    format!("<{tag}{attributes}>{markup}</{tag}>\n")
}

/// `<tag>text</tag>`, escaped.
pub fn plain(tag: &str, text: &str) -> String {
    holding(tag, &escape(text))
}

/// A text that the schema takes: some, without blanks at its ends.
pub fn stated(text: Option<&str>) -> String {
    let words: Vec<&str> = text.unwrap_or_default().split_whitespace().collect();
    if words.is_empty() { "not recorded".into() } else { words.join(" ") }
}

/// A text with its language.
pub fn text(tag: &str, words: &str) -> String {
    holding(tag, &with_attributes("dcc:content", &[("lang", "en")], &escape(words)))
}
