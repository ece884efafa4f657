//! Result files of a Renishaw QC20-W ball bar (`.b5r`, XML): header and ranked features.
//!
//! Known from a public reader, not from the maker: elements TEST_SPEC, OPERATOR, DATE_STARTED, MACHINE_TESTED, SERIAL_NUMBER,
//! LAST_CALIBRATED, PLANE, and FEATURE with NAME, a unit DT and a number as text. Element names of the raw trace are not public: the
//! readings are not read. Wherever these elements stand in the file they are found; the others are skipped.
//! Limits: one test in a file.

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// More features than any such file has; bounds the memory of a file of another kind.
const MOST_FEATURES: usize = 10_000;

/// What a result file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BarResult {
    /// Name of the test.
    pub test: Option<String>,
    /// Who made it.
    pub operator: Option<String>,
    /// When, as the file writes it.
    pub begun: Option<String>,
    /// Name of the machine.
    pub machine: Option<String>,
    /// Of the ball bar.
    pub serial_number: Option<String>,
    /// When the bar was calibrated, as the file writes it.
    pub calibrated: Option<String>,
    /// `XY`, `YZ` or `ZX`.
    pub plane: Option<String>,
    /// Its numbers, in the order of the file.
    pub features: Vec<Feature>,
}

/// One number of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// As the file calls it, e.g. `AF_BACKLASH_A_POS`.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// As people write it; empty for a rank.
    pub unit: &'static str,
}

/// Why a file gives nothing.
#[derive(Debug, thiserror::Error)]
pub enum BarResultError {
    /// No XML.
    #[error("the XML breaks off or is wrong at byte {at}")]
    Xml {
        /// Place in the file.
        at: u64,
        /// The cause.
        source: quick_xml::Error,
    },
    /// A number that is none, or a unit that is not known.
    #[error("feature {name} = \"{text}\" of type {unit}: expected a number of a type among {}", units())]
    Feature {
        /// As the file calls it.
        name: String,
        /// What stands there.
        text: String,
        /// Its type.
        unit: String,
    },
    /// XML of something else.
    #[error("there is no element FEATURE with NAME and DT; a result file of a QC20-W has them")]
    NoFeature,
    /// Too many.
    #[error("there are more than {MOST_FEATURES} features")]
    TooMany,
}

/// Type of a number, its unit, and how many of the unit one is.
const UNITS: [(&str, &str, f64); 9] = [
    ("UT_LENGTH_MM", "µm", 1000.0),
    ("UT_LENGTH_UM", "µm", 1.0),
    ("UT_SQUARENESS", "µm/m", 1.0),
    ("UT_SERVO_MISMATCH", "ms", 1.0),
    ("UT_SCALE_ERROR", "µm/m", 1.0),
    ("UT_FEEDRATE", "mm/min", 1.0),
    ("UT_ANGLE", "°", 1.0),
    ("UT_PERCENT", "%", 1.0),
    ("UT_RANKING", "", 1.0),
];

fn units() -> String {
    UNITS.map(|(name, ..)| name).join(", ")
}

impl BarResult {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// What is no XML, has no feature, or a feature that cannot be read.
    pub fn parse(text: &str) -> Result<Self, BarResultError> {
        let mut reader = Reader::from_str(text);
        let mut result = Self::default();
        // Elements that are open, the innermost last, each with its own text.
        let mut open: Vec<Open> = Vec::new();
        loop {
            let event = reader
                .read_event()
                .map_err(|source| BarResultError::Xml { at: reader.error_position(), source })?;
            match event {
                Event::Start(start) => open.push(Open::new(&start, reader.buffer_position())?),
                Event::Empty(start) => result.take(Open::new(&start, reader.buffer_position())?)?,
                Event::Text(part) => {
                    if let Some(innermost) = open.last_mut() {
                        innermost.text.push_str(&part.xml10_content());
                    }
                }
                Event::End(_) => {
                    if let Some(done) = open.pop() {
                        result.take(done)?;
                    }
                }
                Event::Eof => break,
                _ => {}
            }
        }
        if result.features.is_empty() { Err(BarResultError::NoFeature) } else { Ok(result) }
    }

    /// What one element says.
    fn take(&mut self, element: Open) -> Result<(), BarResultError> {
        let text = element.text.trim();
        let text = (!text.is_empty()).then(|| text.to_owned());
        let named = element.attribute("NAME");
        match element.name.as_str() {
            "TEST_SPEC" => self.test = named.or(text),
            "OPERATOR" => self.operator = text.or(named),
            "DATE_STARTED" => self.begun = text,
            "MACHINE_TESTED" => self.machine = named.or(text),
            "SERIAL_NUMBER" => self.serial_number = text,
            "LAST_CALIBRATED" => self.calibrated = text,
            "PLANE" => self.plane = element.attribute("TEST_PLANE").or(text),
            "FEATURE" => {
                if let Some((name, unit)) = named.zip(element.attribute("DT")) {
                    self.feature(name, unit, text.unwrap_or_default())?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn feature(&mut self, name: String, unit: String, text: String) -> Result<(), BarResultError> {
        if self.features.len() == MOST_FEATURES {
            return Err(BarResultError::TooMany);
        }
        let known = UNITS.iter().find(|(known, ..)| *known == unit);
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let Some((&(_, shown, scale), number)) = known.zip(number) else {
            return Err(BarResultError::Feature { name, text, unit });
        };
        self.features.push(Feature { name, value: scale * number, unit: shown });
        Ok(())
    }
}

/// An element that is open.
struct Open {
    name: String,
    attributes: Vec<(String, String)>,
    text: String,
}

impl Open {
    fn new(start: &BytesStart<'_>, at: u64) -> Result<Self, BarResultError> {
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| BarResultError::Xml { at, source: error.into() })?;
            let value = attribute
                .normalized_value(XmlVersion::Implicit1_0)
                .map_err(|source| BarResultError::Xml { at, source })?;
            attributes.push((attribute.key.local_name().as_ref().to_owned(), value.into_owned()));
        }
        Ok(Self { name: start.local_name().as_ref().to_owned(), attributes, text: String::new() })
    }

    fn attribute(&self, name: &str) -> Option<String> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone())
    }
}
