//! A wave in words.

use super::Wave;

/// Axes are positioned to some 0.1 µm: more digits of a period say nothing, mm and cycles alike.
const MOST_DIGITS: f64 = 4.0;
/// A wave more than a decade finer than the one found is another kind of part (a scale line, not a screw): not worth a sentence.
const DECADE: f64 = 10.0;

impl Wave {
    /// How it repeats, how large it is, and what these positions mistake it for.
    pub fn words(&self) -> String {
        // Two digits of the uncertainty.
        let digits = (1.0 - self.u.max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, MOST_DIGITS) as usize;
        let least = 10.0_f64.powi(-(digits as i32));
        let every = |value: f64| match self.unit {
            "mm" => format!("every {value:.digits$} mm"),
            _ => format!("{value:.digits$} times per turn"),
        };
        let each = if self.unit == "mm" { "mm" } else { "per turn" };
        let spread = match self.u < least {
            true => format!("u < {least:.digits$} {each}"),
            false => format!("u = {:.digits$} {each}", self.u),
        };
        let unit = if self.unit == "mm" { "µm" } else { "µrad" };
        let source = self.is.as_ref().map_or(String::new(), |is| format!(" ({is})"));
        let amplitude = self.amplitude.map_or(String::new(), |size| format!(", amplitude {size:.2} {unit}"));
        let near = |alias: &f64| (alias / self.value).max(self.value / alias) < DECADE;
        let alias = self.alias.filter(near).map_or(String::new(), |alias| {
            format!(
                " On this even grid a wave {} gives the same readings, and so do others without end, the next {}.",
                every(alias),
                every(self.alias_after(alias))
            )
        });
        format!("It repeats {}, {spread}{source}{amplitude}.{alias}", every(self.value))
    }

    /// The alias that follows the first: that one is at ω_s − ω, this at ω_s + ω, and so on about every multiple of ω_s = 2π/step.
    fn alias_after(&self, alias: f64) -> f64 {
        match self.unit {
            "mm" => (1.0 / alias + 2.0 / self.value).recip(),
            _ => alias + 2.0 * self.value,
        }
    }
}
