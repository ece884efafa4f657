//! Stamps of controllers: which of them are times of a measurement.

/// Latest stamp, ns since 1970: in the year 2242. 64 bits hold 9.2e18 ns; what is left lets every wait be added.
const LATEST_NS: i64 = 8_600_000_000_000_000_000;

/// A stamp in ns since 1970 as it came; `None` before 1970 and after 2242, where it is a controller's word for no time (1601, 9999),
/// and differences of two would not fit 64 bits.
pub fn of_measurement(stamp_ns: i64) -> Option<i64> {
    (0..=LATEST_NS).contains(&stamp_ns).then_some(stamp_ns)
}
