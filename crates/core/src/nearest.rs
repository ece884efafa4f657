//! The known name that a mistyped one is closest to.

/// The candidate that differs least, when that is little enough to be a slip: capitals and underscores, one letter in
/// three, or a longer or shorter form (sinus for sin).
pub fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |text: &str| text.to_lowercase().replace('_', "");
    let far = |candidate: &str| {
        let (a, b) = (plain(name), plain(candidate));
        let longer_form = a.len().min(b.len()) >= 3 && (a.starts_with(&b) || b.starts_with(&a));
        if longer_form { usize::from(a != b) } else { distance(&a, &b) }
    };
    let (best, off) = candidates.map(|c| (c, far(c))).min_by_key(|(_, off)| *off)?;
    (off == 0 || (best.len() >= 3 && off <= best.len().div_ceil(3))).then_some(best)
}

/// Letters to change, leave out, put in, or swap with a neighbour.
pub fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let change = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = change.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}
