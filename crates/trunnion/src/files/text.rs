//! Text from the bytes of a file, or what the file is instead.

/// What a file of another kind begins with, what it is, and what to do.
const NO_TEXT: [(&[u8], &str); 4] = [
    (
        b"PK\x03\x04",
        "it is a workbook (.xlsx, .ods) or another archive: save its sheet as CSV, and read that",
    ),
    (b"\xd0\xcf\x11\xe0", "it is a workbook (.xls): save its sheet as CSV, and read that"),
    (b"\x1f\x8b", "it is packed with gzip: unpack it first, with gunzip"),
    (b"%PDF", "it is a PDF: ask for the table as CSV"),
];

/// Windows-1252 from 0x80 on; above 0x9f it is Latin-1. Five places are not used [WHATWG Encoding, windows-1252].
const FROM_80: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}',
    '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

/// UTF-8, or UTF-16 with its mark; else what `otherwise` makes of a text.
pub(super) fn decoded(bytes: Vec<u8>, otherwise: fn(&[u8]) -> Option<String>) -> Result<String, String> {
    let unit: fn([u8; 2]) -> u16 = match bytes[..] {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return of_bytes(bytes, otherwise),
    };
    let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    String::from_utf16(&units).map_err(|error| format!("it is no text in UTF-16: {error}"))
}

fn of_bytes(bytes: Vec<u8>, otherwise: fn(&[u8]) -> Option<String>) -> Result<String, String> {
    if let Some((_, what)) = NO_TEXT.iter().find(|(begins, _)| bytes.starts_with(begins)) {
        return Err((*what).into());
    }
    if bytes.contains(&0) {
        return Err("it is no text in UTF-8: it holds zeros. Where a program wrote it in UTF-16 or UTF-32, save it in UTF-8".into());
    }
    String::from_utf8(bytes).or_else(|error| {
        let at = error.utf8_error().valid_up_to();
        otherwise(error.as_bytes()).ok_or_else(|| {
            let line = 1 + error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
            format!("line {line} is no text in UTF-8: save the file in UTF-8")
        })
    })
}

/// `None` where a byte is no letter.
pub(super) fn windows_1252(bytes: &[u8]) -> Option<String> {
    let is_text = |byte: &u8| *byte >= b' ' || [b'\t', b'\n', b'\r'].contains(byte);
    let letter = |byte: &u8| match *byte {
        0x80..=0x9f => FROM_80[usize::from(byte - 0x80)],
        other => char::from(other),
    };
    bytes.iter().all(is_text).then(|| bytes.iter().map(letter).collect())
}
