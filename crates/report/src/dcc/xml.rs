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
