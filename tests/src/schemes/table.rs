//! The table of trials in docs/measured/schemes.md.

use super::judged::Found;
use super::rows::Row;
use super::trial::NoiseKind;

/// Section of the document that the trials write.
pub const SECTION: &str = "seeds";
/// Columns of the table.
pub const NOISES: [(NoiseKind, &str); 2] =
    [(NoiseKind::White, "white noise"), (NoiseKind::DriftAndSteps, "drift and steps of passes")];
/// Largest deviation that some ten thousand numbers of a normal distribution have, in standard uncertainties, rounded up.
const MOST_Z: f64 = 4.5;
/// Standard uncertainties that are right within a fifth: what thirty seeds can show.
const RMS_Z: std::ops::RangeInclusive<f64> = 0.8..=1.2;

/// Half of a 95 % interval in standard uncertainties [GUM G.6.6].
const COVERAGE_95: f64 = 1.96;

/// The trials of one row with one noise.
#[derive(Clone, Debug, Default)]
pub struct Tried {
    /// All numbers of all seeds.
    pub found: Vec<Found>,
    /// Fits that failed.
    pub failed: usize,
}

impl Tried {
    /// Root mean square deviation in standard uncertainties.
    pub fn rms_z(&self) -> f64 {
        (self.found.iter().map(|found| z(found).powi(2)).sum::<f64>() / self.found.len() as f64).sqrt()
    }

    /// Share of the numbers whose 95 % interval holds the injected value.
    fn held(&self) -> f64 {
        self.found.iter().filter(|found| z(found).abs() <= COVERAGE_95).count() as f64
            / self.found.len() as f64
    }

    /// The number that is farthest off.
    pub fn worst(&self) -> Option<&Found> {
        self.found.iter().max_by(|a, b| z(a).abs().total_cmp(&z(b).abs()))
    }

    fn cells(&self) -> String {
        let Some(worst) = self.worst() else { return format!("**{} failed** | | ", self.failed) };
        let marked = |text: String, good: bool| if good { text } else { format!("**{text}**") };
        let (most, rms) = (z(worst).abs(), self.rms_z());
        let failed = if self.failed == 0 { String::new() } else { format!(", **{} failed**", self.failed) };
        format!(
            "{} ({}){failed} | {} | {:.0} %",
            marked(format!("{most:.1}"), most <= MOST_Z),
            worst.name,
            marked(format!("{rms:.2}"), RMS_Z.contains(&rms)),
            100.0 * self.held()
        )
    }
}

/// One line: a row of the schemes, and its trials with each of the noises.
pub fn line(row: &Row, seeds: u64, tried: &[Tried]) -> String {
    let numbers = tried.iter().map(|tried| tried.found.len()).max().unwrap_or(0);
    let cells: Vec<String> = tried.iter().map(Tried::cells).collect();
    format!("| {} | {seeds} | {numbers} | {} |\n", row.scheme, cells.join(" | "))
}

/// Deviation in standard uncertainties.
fn z(found: &Found) -> f64 {
    (found.value - found.expected) / found.u
}
