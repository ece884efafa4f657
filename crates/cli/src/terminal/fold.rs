//! Lists that are longer than the screen are shortened to it, and end with how many items follow.
//!
//! A list is a stretch of lines with no empty line in it. Most of its lines are items; what is indented deeper than they are
//! continues the item above it.

/// `text` with every list shortened to at most `screen` lines of the terminal; `height` is how many of them a line takes.
pub fn fold(text: &str, screen: usize, height: &dyn Fn(&str) -> usize) -> String {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    lines
        .chunk_by(|one, next| is_empty(one) == is_empty(next))
        .map(|list| shortened(list, screen, height))
        .collect()
}

fn shortened(list: &[&str], screen: usize, height: &dyn Fn(&str) -> usize) -> String {
    let heights: Vec<usize> = list.iter().map(|line| height(line.trim_end_matches('\n'))).collect();
    if is_empty(list[0]) || heights.iter().sum::<usize>() <= screen {
        return list.concat();
    }
    let level = level(list);
    let begins: Vec<usize> = (0..list.len()).filter(|&at| indent(list[at]) <= level).collect();
    // The last line of the screen says how many more there are; one item is always shown.
    let fits = |end: &usize| heights[..*end].iter().sum::<usize>() < screen;
    let shown = begins.iter().skip(1).take_while(|end| fits(end)).count().max(1);
    match begins.get(shown) {
        Some(&end) => {
            let more = begins.len() - shown;
            format!("{}{}… and {more} more: --all\n", list[..end].concat(), " ".repeat(level))
        }
        None => list.concat(),
    }
}

/// The indentation that most lines have; of two as frequent the smaller.
fn level(list: &[&str]) -> usize {
    let count = |level: usize| list.iter().filter(|line| indent(line) == level).count();
    let levels = list.iter().map(|line| indent(line));
    levels.max_by_key(|&level| (count(level), std::cmp::Reverse(level))).unwrap_or(0)
}

fn indent(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

fn is_empty(line: &str) -> bool {
    line.trim().is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(text: &str, screen: usize, expected: &str) {
        assert_eq!(fold(text, screen, &|line| 1 + line.len() / 40), expected, "{text:?}");
    }

    #[test]
    fn a_list_longer_than_the_screen_ends_with_how_many_more_there_are() {
        check("", 3, "");
        check("a\nb\nc\n", 3, "a\nb\nc\n");
        check("a\nb\nc\nd\n", 3, "a\nb\n… and 2 more: --all\n");
        check("a\nb\nc\nd", 3, "a\nb\n… and 2 more: --all\n");
        check("a\nb\n\nc\nd\n", 3, "a\nb\n\nc\nd\n");
        check("head\n  a\n  b\n  c\n\nend\n", 3, "head\n  a\n  … and 2 more: --all\n\nend\n");
    }

    #[test]
    fn what_continues_an_item_stays_with_it_and_is_not_counted() {
        check("a\n  why\nb\n  why\nc\n  why\n", 4, "a\n  why\n… and 2 more: --all\n");
        check("a\n  why\n  why\nb\nc\nd\n", 4, "a\n  why\n  why\n… and 3 more: --all\n");
    }

    #[test]
    fn a_line_that_takes_several_of_the_screen_counts_as_many() {
        let long = "x".repeat(100);
        check(&format!("a\n{long}\nb\nc\n"), 5, &format!("a\n{long}\n… and 2 more: --all\n"));
        check(&format!("{long}\n{long}\n"), 2, &format!("{long}\n… and 1 more: --all\n"));
    }

    proptest! {
        #[test]
        fn shown_and_folded_items_are_all_items(items in 1_usize..200, screen in 2_usize..60) {
            let text: String = (0..items).map(|item| format!("  item {item}\n")).collect();
            let folded = fold(&text, screen, &|_| 1);
            prop_assert!(folded.lines().count() <= screen);
            let shown = folded.lines().filter(|line| line.starts_with("  item")).count();
            let count = |line: &str| line.strip_prefix("  … and ")?.split(' ').next()?.parse::<usize>().ok();
            let more: usize = folded.lines().filter_map(count).sum();
            prop_assert_eq!(shown + more, items);
        }
    }
}
