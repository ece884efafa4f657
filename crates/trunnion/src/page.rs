//! What every page says of itself, and losses in sentences.

use trunnion_core::Gap;

/// What made a page.
pub fn label() -> String {
    format!("Trunnion {}", env!("CARGO_PKG_VERSION"))
}

/// Holes in the data, one sentence each.
pub fn losses(gaps: &[Gap], lost_samples: u64) -> Vec<String> {
    let mut losses: Vec<String> = gaps
        .iter()
        .map(|gap| {
            let lost = gap.lost_samples.map_or(String::new(), |n| format!(", {n} samples missing"));
            format!(
                "{}: nothing from {:.2} s to {:.2} s{lost} ({})",
                gap.source, gap.from_s, gap.to_s, gap.reason
            )
        })
        .collect();
    if lost_samples > 0 {
        losses.push(format!("{lost_samples} samples could not be written to disk"));
    }
    losses
}
