//! Names that a person may have mistyped: the nearest known one, and what is allowed in few words.

use strsim::damerau_levenshtein;

/// Up to so many allowed names are listed in full; of more, only the nearest.
const MOST_LISTED: usize = 12;
/// Names shown of a longer list.
const NEAREST_SHOWN: usize = 4;
/// A longer name is no slip of a known one, and comparing letters takes their product: a line of a megabyte would take minutes.
const LONGEST_SLIP: usize = 100;

/// The candidate that differs least, when that is little enough to be a slip: capitals, `_` and `-`, one letter in
/// three, or a longer or shorter form (sinus for sin).
pub fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let (best, off) = candidates.map(|c| (c, distance(name, c))).min_by_key(|(_, off)| *off)?;
    (off == 0 || (best.len() >= 3 && off <= best.len().div_ceil(3))).then_some(best)
}

/// Letters to change, leave out, put in, or swap with a neighbour; a longer or shorter form of the same word counts one.
pub fn distance(name: &str, candidate: &str) -> usize {
    let plain = |text: &str| text.to_lowercase().replace(['_', '-'], "");
    let (a, b) = (plain(name), plain(candidate));
    let longer_form = a.len().min(b.len()) >= 3 && (a.starts_with(&b) || b.starts_with(&a));
    match longer_form {
        true => usize::from(a != b),
        false if a.len().max(b.len()) > LONGEST_SLIP => a.len().max(b.len()),
        false => damerau_levenshtein(&a, &b),
    }
}

/// What may stand in place of `name`, to be put after "allowed: ": all names when they are few, else the nearest and
/// how many more there are; with a question where one is near enough to be meant.
pub fn allowed<T: AsRef<str>>(name: &str, candidates: impl IntoIterator<Item = T>) -> String {
    let all: Vec<T> = candidates.into_iter().collect();
    let mut names: Vec<&str> = all.iter().map(AsRef::as_ref).collect();
    let meant = nearest(name, names.iter().copied());
    let mut text = if names.len() <= MOST_LISTED {
        names.join(", ")
    } else {
        names.sort_by_cached_key(|candidate| distance(name, candidate));
        let more = names.len() - NEAREST_SHOWN;
        format!("{} and {more} more", names[..NEAREST_SHOWN].join(", "))
    };
    if let Some(meant) = meant {
        text += &format!(" (did you mean {meant}?)");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_the_name_that_was_meant() {
        let names = ["gravity-sag:B", "backlash:C", "thermal-drift"];
        for slip in ["gravty-sag:B", "gravity_sag:b", "Gravity-Sag:B", "gravity-sga:B"] {
            assert_eq!(nearest(slip, names.into_iter()), Some("gravity-sag:B"), "{slip}");
        }
        assert_eq!(nearest("probe", names.into_iter()), None);
    }

    #[test]
    fn a_name_without_end_is_no_slip() {
        let endless = "e-".repeat(1_000_000);
        let many: Vec<String> = (10..60).map(|n| format!("effect-{n}")).collect();
        assert!(allowed(&endless, &many).ends_with(" and 46 more"));
        // Letter by letter it would be less by those that both have.
        assert_eq!(distance(&endless, "effect-10"), 1_000_000);
    }

    #[test]
    fn a_long_list_is_folded_to_the_nearest() {
        let many: Vec<String> = (10..60).map(|n| format!("effect-{n}")).collect();
        let folded = allowed("efect-42", &many);
        assert!(folded.starts_with("effect-42, "), "{folded}");
        assert!(folded.ends_with(" and 46 more (did you mean effect-42?)"), "{folded}");
        assert_eq!(allowed("zzz", ["low", "high"]), "low, high");
    }
}
