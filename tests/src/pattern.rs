//! Texts in which a part differs from run to run.

/// True when `text` is `pattern`, whose `*` stand for anything.
pub fn is_like(text: &str, pattern: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return text == pattern };
    let Some(mut left) = text.strip_prefix(first) else { return false };
    let mut pieces: Vec<&str> = rest.split('*').collect();
    let last = pieces.pop().unwrap_or_default();
    for piece in pieces {
        let Some(at) = left.find(piece) else { return false };
        left = &left[at + piece.len()..];
    }
    left.ends_with(last)
}

#[test]
fn a_star_stands_for_anything() {
    assert!(is_like("silent for 251 ms: PORT", "silent for * ms: PORT") && is_like("x", "*"));
    assert!(!is_like("silent for 251 ms", "silent for * ms: PORT") && !is_like("ab", "a*b*b"));
}
