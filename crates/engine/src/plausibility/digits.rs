//! The steps in which numbers of a file are given.

/// Finer steps, of 10⁻⁵ mm or degrees, hide nothing that a machine shows.
const MOST_DECIMALS: i32 = 5;
/// A number is a multiple of a step within this share of it: a conversion moves it by 10⁻⁹, and of others two in a million are so near.
const WHOLE: f64 = 1e-6;

/// The coarsest power of ten of which all of some numbers are multiples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Digits {
    decimals: i32,
}

impl Digits {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut digits = Self::default();
        values.into_iter().for_each(|value| digits.take(value));
        digits
    }

    pub fn take(&mut self, value: f64) {
        while self.decimals < MOST_DECIMALS && !is_multiple(value, 10f64.powi(-self.decimals)) {
            self.decimals += 1;
        }
    }

    /// `None` where they are so fine that it is no rounding.
    pub fn step(self) -> Option<f64> {
        (self.decimals < MOST_DECIMALS).then(|| 10f64.powi(-self.decimals))
    }
}

/// Significant digits that all of some numbers keep to; `None` where they need more than `most`.
pub(super) fn significant(values: &[f64], most: i32) -> Option<i32> {
    let step = |value: f64, digits: i32| significant_step(value, digits);
    (1..=most).find(|&digits| {
        values.iter().filter(|value| **value != 0.0).all(|value| is_multiple(*value, step(*value, digits)))
    })
}

/// The last of so many significant digits of a number.
pub(super) fn significant_step(value: f64, digits: i32) -> f64 {
    10f64.powi(value.abs().log10().floor() as i32 + 1 - digits)
}

fn is_multiple(value: f64, step: f64) -> bool {
    (value / step - (value / step).round()).abs() < WHOLE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarsest_step_of_numbers_is_found() {
        assert_eq!(Digits::of([100.0, 250.0]).step(), Some(1.0));
        assert_eq!(Digits::of([-99.28, 0.0, 12.5]).step(), Some(0.01));
        assert_eq!(Digits::of([12.5, 1.0 / 3.0]).step(), None);
        assert_eq!(significant(&[101.0, 22.3, 0.104], 3), Some(3));
        assert_eq!(significant(&[101.0, 22.34], 3), None);
    }
}
