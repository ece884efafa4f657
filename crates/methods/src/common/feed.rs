//! When two speeds are one feed.

/// Speeds within this factor are one feed: a control holds a feed to a few per cent, and feeds that are compared differ by more.
pub(crate) const ONE_FEED: f64 = 1.1;

/// Whether two speeds, both above zero, are one feed.
pub(crate) fn is_one_feed(a: f64, b: f64) -> bool {
    (a / b).ln().abs() <= ONE_FEED.ln()
}
