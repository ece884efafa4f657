//! From values to places on the drawing, and the round numbers in between.

/// A straight scale.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// `low` at `from`, `high` at `to`; an empty or infinite range becomes −1…1 around its middle.
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        let usable = low.is_finite() && high.is_finite();
        let (low, high) = match usable {
            true if high > low => (low, high),
            true => (low - 1.0, low + 1.0),
            false => (-1.0, 1.0),
        };
        Self { low, high, from, to }
    }

    /// Place of a value.
    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round values inside the scale, about `count` of them, and their step.
    pub fn ticks(&self, count: usize) -> (Vec<f64>, f64) {
        let step = nice_above((self.high - self.low) / count.max(1) as f64);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        ((first..=last).map(|i| i as f64 * step).collect(), step)
    }
}

/// Two scales of one size: a millimetre is as long across as up.
pub struct Plane {
    pub x: Scale,
    pub y: Scale,
    /// Height of the drawing.
    pub height: f64,
    /// Its lower edge.
    pub bottom: f64,
}

impl Plane {
    /// Around all places, with so much room (factors across and up), no lower than `least_height`, in the square whose
    /// left, upper edge and side are given.
    pub fn around(
        places: impl Iterator<Item = (f64, f64)> + Clone,
        (across, up): (f64, f64),
        least_height: f64,
        (left, top, side): (f64, f64, f64),
    ) -> Self {
        let (west, east) = extent(places.clone().map(|place| place.0)).unwrap_or((-1.0, 1.0));
        let (low, high) = extent(places.map(|place| place.1)).unwrap_or((-1.0, 1.0));
        let mm_per_unit = ((east - west).max(high - low) * across).max(1e-6) / side;
        let height = ((high - low) * up / mm_per_unit).clamp(least_height, side);
        let bottom = top + height;
        let scale = |low: f64, high: f64, length: f64, ends: (f64, f64)| {
            let (middle, half) = ((low + high) / 2.0, length / 2.0 * mm_per_unit);
            Scale::new((middle - half, middle + half), ends)
        };
        Self {
            x: scale(west, east, side, (left, left + side)),
            y: scale(low, high, height, (bottom, top)),
            height,
            bottom,
        }
    }
}

/// Steps that can be counted by a reader.
const STEPS: &[f64] = &[1.0, 2.0, 5.0];
/// Ends of a scale, at most half as large again as the one before: a map whose largest value is just above a step is not pale.
const ENDS: &[f64] = &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];

/// A step between ticks, or a magnification: the smallest of …, 1, 2, 5, 10, … that is not below `value`; 1 for what is not positive.
pub fn nice_above(value: f64) -> f64 {
    above(value, STEPS)
}

/// The end of a scale that holds `value`: a round number, closer to it than a step is; 1 for what is not positive.
pub fn end_above(value: f64) -> f64 {
    above(value, ENDS)
}

fn above(value: f64, of_decade: &[f64]) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let decade = 10_f64.powf(value.log10().floor());
    let round = of_decade.iter().map(|m| m * decade).find(|n| *n >= value * (1.0 - 1e-9));
    round.unwrap_or(10.0 * decade)
}

/// Least and largest finite value; `None` when there is none.
pub fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| {
        Some(range.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v))))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let (ticks, step) = Scale::new((-3.2, 7.9), (0.0, 100.0)).ticks(5);
        assert_eq!((ticks.as_slice(), step), ([0.0, 5.0].as_slice(), 5.0));
        assert_eq!(Scale::new((0.0, 90.0), (0.0, 1.0)).ticks(5).0.len(), 5);
    }

    #[test]
    fn a_scale_ends_close_above_its_largest_value() {
        let ends = [0.0, 0.21, 1.0, 1.2, 20.4, 51.0, 83.0, 10.0].map(end_above);
        assert_eq!(ends, [1.0, 0.25, 1.0, 1.5, 25.0, 60.0, 100.0, 10.0]);
        for value in (1..1000).map(f64::from) {
            assert!((value..=1.5 * value).contains(&end_above(value)), "{value}");
        }
    }

    #[test]
    fn a_scale_of_nothing_still_places_values() {
        for range in [(f64::NAN, 1.0), (2.0, 2.0), (f64::INFINITY, f64::NEG_INFINITY)] {
            assert!(Scale::new(range, (0.0, 10.0)).at(2.0).is_finite());
        }
    }
}
