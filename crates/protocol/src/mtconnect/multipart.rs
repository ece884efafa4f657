//! The stream of `/sample?interval=`: `multipart/x-mixed-replace` (newer C++ agents: `multipart/mixed`), each part
//! with its own `Content-length`.
//! Parts are cut by their length; a part without a usable one is skipped to the next boundary and counted. What stands behind a closing
//! boundary is dropped and counted as well; where a further part begins there, the boundary was a damaged one and closed nothing.

use thiserror::Error;

/// One part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// `Content-type`, `text/xml` for example; empty when missing.
    pub content_type: String,
    /// The document.
    pub body: Vec<u8>,
}

/// Why a response is not a multipart stream.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("Content-Type \"{0}\" names no multipart boundary; is this the answer to /sample with interval?")]
pub struct MultipartError(pub String);

/// What was dropped since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MultipartLosses {
    /// Parts without a usable length.
    pub bad_parts: u64,
    /// Bytes outside of parts, line ends and boundaries not counted.
    pub dropped_bytes: u64,
}

/// A document of an agent is far smaller: a device model of 30 000 elements, or a thousand observations, has some 5 MB. A longer part
/// is skipped.
pub const MAX_BODY_BYTES: usize = 16 * 1024 * 1024;
const MAX_HEADER_BYTES: usize = 8 * 1024;

/// The boundary named by a `Content-Type` header.
pub fn boundary(content_type: &str) -> Result<String, MultipartError> {
    let missing = || MultipartError(content_type.to_owned());
    let mut parameters = content_type.split(';');
    let multipart =
        parameters.next().is_some_and(|kind| kind.trim().to_ascii_lowercase().starts_with("multipart/"));
    let value = parameters.find_map(|parameter| {
        let (name, value) = parameter.split_once('=')?;
        name.trim().eq_ignore_ascii_case("boundary").then(|| value.trim().trim_matches('"').to_owned())
    });
    value.filter(|value| multipart && !value.is_empty()).ok_or_else(missing)
}

/// Cuts the stream into parts.
#[derive(Debug, Clone)]
pub struct MultipartDecoder {
    delimiter: Vec<u8>,
    buffer: Vec<u8>,
    state: State,
    losses: MultipartLosses,
}

#[derive(Debug, Clone)]
enum State {
    Delimiter,
    Header,
    Body { content_type: String, length: usize },
}

impl MultipartDecoder {
    /// For the value of the response's `Content-Type` header.
    pub fn new(content_type: &str) -> Result<Self, MultipartError> {
        let delimiter = format!("--{}", boundary(content_type)?).into_bytes();
        let losses = MultipartLosses::default();
        Ok(Self { delimiter, buffer: Vec::new(), state: State::Delimiter, losses })
    }

    /// What was dropped since the start.
    pub fn losses(&self) -> MultipartLosses {
        self.losses
    }

    /// Takes bytes as read and returns the parts they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Part> {
        self.buffer.extend_from_slice(bytes);
        let mut parts = Vec::new();
        while self.step(&mut parts) {}
        parts
    }

    /// Does one step with what is buffered; false when more bytes are needed.
    fn step(&mut self, parts: &mut Vec<Part>) -> bool {
        match &mut self.state {
            State::Delimiter => self.find_delimiter(),
            State::Header => self.read_header(),
            State::Body { length, .. } if self.buffer.len() < *length => false,
            State::Body { content_type, length } => {
                let rest = self.buffer.split_off(*length);
                let body = std::mem::replace(&mut self.buffer, rest);
                parts.push(Part { content_type: std::mem::take(content_type), body });
                self.state = State::Delimiter;
                true
            }
        }
    }

    fn find_delimiter(&mut self) -> bool {
        let Some(at) = find(&self.buffer, &self.delimiter) else {
            // All but what may be the beginning of a delimiter is of no use.
            let keep = self.buffer.len().min(self.delimiter.len() - 1);
            self.drop_front(self.buffer.len() - keep);
            return false;
        };
        self.drop_front(at);
        let end = self.delimiter.len();
        // The two bytes behind show whether it is the last: `--` or a line end.
        let Some(behind) = self.buffer.get(end..end + 2) else { return false };
        let closes = behind == b"--";
        let line_end = behind == b"\r\n" || behind[0] == b'\n';
        self.buffer.drain(..if closes { end + 2 } else { end });
        if line_end {
            self.state = State::Header;
        }
        true
    }

    fn read_header(&mut self) -> bool {
        let ends = [&b"\r\n\r\n"[..], b"\n\n"];
        let end = ends.iter().filter_map(|end| Some(find(&self.buffer, end)? + end.len())).min();
        let Some(end) = end.filter(|&end| end <= MAX_HEADER_BYTES) else {
            if end.is_some() || self.buffer.len() >= MAX_HEADER_BYTES {
                return self.skip_part();
            }
            return false;
        };
        let (mut content_type, mut length) = (String::new(), None);
        for line in String::from_utf8_lossy(&self.buffer[..end]).lines() {
            match line.split_once(':') {
                Some((name, value)) if name.trim().eq_ignore_ascii_case("content-length") => {
                    length = value.trim().parse().ok();
                }
                Some((name, value)) if name.trim().eq_ignore_ascii_case("content-type") => {
                    content_type = value.trim().to_owned();
                }
                _ => {}
            }
        }
        let Some(length) = length.filter(|&length| length <= MAX_BODY_BYTES) else { return self.skip_part() };
        self.buffer.drain(..end);
        self.state = State::Body { content_type, length };
        true
    }

    fn skip_part(&mut self) -> bool {
        self.losses.bad_parts += 1;
        self.state = State::Delimiter;
        true
    }

    fn drop_front(&mut self, count: usize) {
        self.losses.dropped_bytes += visible(&self.buffer[..count]);
        self.buffer.drain(..count);
    }
}

/// The bytes of one part, as an agent sends them; the first part of a response begins the same way.
pub fn encode_part(boundary: &str, content_type: &str, body: &[u8]) -> Vec<u8> {
    let header =
        format!("--{boundary}\r\nContent-type: {content_type}\r\nContent-length: {}\r\n\r\n", body.len());
    [header.as_bytes(), body, b"\r\n"].concat()
}

fn find(haystack: &[u8], needle: &[u8]) -> Option<usize> {
    haystack.windows(needle.len()).position(|window| window == needle)
}

fn visible(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|byte| !matches!(byte, b'\r' | b'\n')).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TYPE: &str = "multipart/x-mixed-replace;boundary=a8e12eced4fb871ac096a99bf9728425";

    fn decoder() -> MultipartDecoder {
        MultipartDecoder::new(TYPE).unwrap()
    }

    #[test]
    fn the_boundary_is_read_from_the_header() {
        let check = |text: &str, expected: Option<&str>| {
            assert_eq!(boundary(text).ok().as_deref(), expected, "{text}");
        };
        check(TYPE, Some("a8e12eced4fb871ac096a99bf9728425"));
        check("Multipart/X-mixed-replace; charset=x; Boundary=\"b c\"", Some("b c"));
        check("text/xml; boundary=x", None);
        check("multipart/x-mixed-replace", None);
    }

    #[test]
    fn bytes_before_a_boundary_are_counted_before_it_is_complete() {
        let boundary = format!("xy--{}", boundary(TYPE).unwrap());
        for cut in 0..boundary.len() {
            let mut decoder = decoder();
            decoder.push(&boundary.as_bytes()[..cut]);
            decoder.push(&boundary.as_bytes()[cut..]);
            assert_eq!(decoder.losses().dropped_bytes, 2, "cut at {cut}");
        }
    }

    #[test]
    fn a_part_that_contains_the_boundary_is_cut_by_its_length() {
        let body = format!("<x/>\r\n--{}\r\nContent-length: 3\r\n\r\n", boundary(TYPE).unwrap());
        let bytes = encode_part(&boundary(TYPE).unwrap(), "text/xml", body.as_bytes());
        let parts = decoder().push(&bytes);
        assert_eq!(parts, [Part { content_type: "text/xml".into(), body: body.into_bytes() }]);
    }

    #[test]
    fn a_part_without_a_length_is_skipped_and_counted() {
        let name = boundary(TYPE).unwrap();
        let good = encode_part(&name, "text/xml", b"<x/>");
        let bad = format!("--{name}\r\nContent-type: text/xml\r\n\r\n<lost/>\r\n");
        let mut decoder = decoder();
        let parts = decoder.push(&[bad.as_bytes(), &good, format!("--{name}--\r\n").as_bytes()].concat());
        assert_eq!(parts.len(), 1);
        let header_and_body = "Content-type: text/xml<lost/>".len() as u64;
        assert_eq!(decoder.losses(), MultipartLosses { bad_parts: 1, dropped_bytes: header_and_body });
        assert_eq!(decoder.push(&good).len(), 1, "what closes nothing hides nothing");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn parts_survive_however_the_stream_is_split(
            bodies in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..60), 1..5),
            cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..8),
        ) {
            let name = boundary(TYPE).unwrap();
            let bytes: Vec<u8> = bodies.iter().flat_map(|body| encode_part(&name, "text/xml", body)).collect();
            let mut at: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len())).collect();
            at.extend([0, bytes.len()]);
            at.sort_unstable();
            let mut decoder = decoder();
            let parts: Vec<_> = at.windows(2).flat_map(|w| decoder.push(&bytes[w[0]..w[1]])).collect();
            prop_assert_eq!(parts.into_iter().map(|part| part.body).collect::<Vec<_>>(), bodies);
            prop_assert_eq!(decoder.losses(), MultipartLosses::default());
        }

        #[test]
        fn any_split_of_garbage_gives_the_same_and_a_part_is_found_after_it(
            garbage in prop::collection::vec(prop::sample::select(b"-ab\r\n:C".to_vec()), 0..200),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = garbage.clone();
            bytes.extend(encode_part("ab", "text/xml", b"<x/>"));
            let new = || MultipartDecoder::new("multipart/mixed;boundary=ab").unwrap();
            let (mut whole, mut split) = (new(), new());
            let expected = whole.push(&bytes);
            let (head, tail) = bytes.split_at(cut.index(bytes.len()));
            let got = [split.push(head), split.push(tail)].concat();
            prop_assert_eq!(&got, &expected);
            prop_assert_eq!(split.losses(), whole.losses());
            if !garbage.windows(4).any(|window| window == b"--ab") && !garbage.ends_with(b"-") {
                prop_assert_eq!(got.len(), 1);
                prop_assert_eq!(whole.losses().dropped_bytes, visible(&garbage));
            }
        }
    }
}
