//! A wave in words.

use super::Wave;

/// Nobody reads a smaller uncertainty of a period, mm or cycles.
const FINEST: f64 = 1e-5;

impl Wave {
    /// How it repeats, how large it is, and what these positions mistake it for.
    pub fn words(&self) -> String {
        // Two digits of the uncertainty.
        let digits = (1.0 - self.u.max(FINEST).log10().floor()).clamp(0.0, 6.0) as usize;
        let every = |value: f64| match self.unit {
            "mm" => format!("every {value:.digits$} mm"),
            _ => format!("{value:.digits$} times per turn"),
        };
        let spread = format!("{:.digits$}", self.u);
        let unit = if self.unit == "mm" { "µm" } else { "µrad" };
        let source = self.is.as_ref().map_or(String::new(), |is| format!(" ({is})"));
        let amplitude = self.amplitude.map_or(String::new(), |size| format!(", amplitude {size:.2} {unit}"));
        let alias = self.alias.map_or(String::new(), |alias| {
            format!(" On this even grid a wave {} gives the same readings.", every(alias))
        });
        format!("It repeats {}, u = {spread}{source}{amplitude}.{alias}", every(self.value))
    }
}
