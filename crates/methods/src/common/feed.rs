//! When two speeds are one feed, and the feeds that many speeds make.

use trunnion_core::statistics::upper_median;

/// Speeds within this factor are one feed: a control holds a feed to a few per cent, and feeds that are compared differ by more. A judgement,
/// tuned on no data.
const ONE_FEED: f64 = 1.1;

/// Whether two speeds, both above zero, are one feed.
pub(crate) fn is_one_feed(a: f64, b: f64) -> bool {
    (a / b).ln().abs() <= ONE_FEED.ln()
}

/// Speeds above zero by feed, slowest first: all that are one feed with the slowest of them.
pub(crate) fn by_feed(mut speeds: Vec<f64>) -> Vec<Vec<f64>> {
    speeds.sort_by(f64::total_cmp);
    let mut feeds: Vec<Vec<f64>> = Vec::new();
    for speed in speeds {
        match feeds.last_mut() {
            Some(feed) if is_one_feed(feed[0], speed) => feed.push(speed),
            _ => feeds.push(vec![speed]),
        }
    }
    feeds
}

/// The feeds of speeds above zero, each the middle of its speeds, slowest first.
pub(crate) fn feeds(speeds: Vec<f64>) -> Vec<f64> {
    by_feed(speeds).iter().filter_map(|speeds| upper_median(speeds)).collect()
}

/// Which of the feeds a speed is: the nearest, where they are one feed.
pub(crate) fn feed_of(feeds: &[f64], speed: f64) -> Option<usize> {
    let apart = |k: &usize| (feeds[*k] / speed).ln().abs();
    let nearest = (0..feeds.len()).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    is_one_feed(feeds[nearest], speed).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_a_few_per_cent_apart_are_one_feed() {
        assert_eq!(feeds(vec![33.0, 10.0, 9.8, 31.0, 10.2, 32.0]), [10.0, 32.0]);
        assert_eq!((feed_of(&[10.0, 32.0], 33.0), feed_of(&[10.0, 32.0], 20.0)), (Some(1), None));
        assert_eq!((feeds(vec![]), feed_of(&[], 1.0)), (vec![], None));
    }
}
