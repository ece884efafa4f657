//! An XML document as a tree of elements with local names, so that the documents can be read top-down.

use super::document::DocumentError;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// Deeper nesting than any MTConnect device model; bounds the stack when the tree is walked and dropped.
const MAX_DEPTH: usize = 64;

/// Elements and attributes of one document. The device model of a large machine has some 30 000; a tree of these takes below 100 MB.
const MOST_PARTS: usize = 500_000;

#[derive(Debug, Default)]
pub(super) struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub text: String,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    pub fn need(&self, name: &'static str) -> Result<&str, DocumentError> {
        let missing = || DocumentError::MissingAttribute { element: self.name.clone(), attribute: name };
        self.attribute(name).ok_or_else(missing)
    }

    pub fn number(&self, name: &'static str) -> Result<u64, DocumentError> {
        let text = self.need(name)?;
        let wrong = |_| DocumentError::WrongNumber {
            element: self.name.clone(),
            attribute: name,
            text: text.to_owned(),
        };
        text.trim().parse().map_err(wrong)
    }
}

pub(super) fn parse_tree(bytes: &[u8]) -> Result<Element, DocumentError> {
    let text =
        std::str::from_utf8(bytes).map_err(|error| DocumentError::NotUtf8 { at: error.valid_up_to() })?;
    let mut reader = Reader::from_str(text);
    // The document is the only child of this one.
    let mut open = vec![Element::default()];
    let mut parts = 0;
    let mut counted = |element: Element| {
        parts += 1 + element.attributes.len();
        if parts > MOST_PARTS { Err(DocumentError::TooMany { limit: MOST_PARTS }) } else { Ok(element) }
    };
    loop {
        let event = reader
            .read_event()
            .map_err(|source| DocumentError::Xml { at: reader.error_position(), source })?;
        let top = open.last_mut().expect("the document element stays open");
        match event {
            Event::Start(start) => {
                if open.len() > MAX_DEPTH {
                    return Err(DocumentError::TooDeep);
                }
                open.push(counted(element(&start, reader.buffer_position())?)?);
            }
            Event::Empty(start) => top.children.push(counted(element(&start, reader.buffer_position())?)?),
            Event::End(_) => {
                let done = open.pop().filter(|_| !open.is_empty()).ok_or(DocumentError::Empty)?;
                open.last_mut().expect("checked above").children.push(done);
            }
            Event::Text(text) => top.text.push_str(&text.xml10_content()),
            Event::CData(data) => top.text.push_str(&data.xml10_content()),
            Event::GeneralRef(reference) => top.text.push_str(&resolve(&reference.xml10_content())),
            Event::Eof => break,
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
        }
    }
    if open.len() > 1 {
        return Err(DocumentError::Truncated);
    }
    open.pop().and_then(|root| root.children.into_iter().next()).ok_or(DocumentError::Empty)
}

fn element(start: &BytesStart<'_>, at: u64) -> Result<Element, DocumentError> {
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|error| DocumentError::Xml { at, source: error.into() })?;
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|source| DocumentError::Xml { at, source })?;
        attributes.push((attribute.key.local_name().as_ref().to_owned(), value.into_owned()));
    }
    Ok(Element { name: start.local_name().as_ref().to_owned(), attributes, ..Element::default() })
}

/// An entity in text; one that is not known stays as it was written.
fn resolve(name: &str) -> String {
    let escaped = format!("&{name};");
    quick_xml::escape::unescape(&escaped).map_or_else(|_| escaped.clone(), |text| text.into_owned())
}
