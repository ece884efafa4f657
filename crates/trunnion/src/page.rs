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
            // What came too late to have a moment was counted where it was missed.
            let lost = gap.lost_samples.filter(|n| *n > 0);
            let lost = lost.map_or(String::new(), |n| format!(", {n} samples missing"));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_without_a_missing_sample_counts_none() {
        let gap = |lost_samples| Gap {
            source: "probe-1".into(),
            from_s: 1.0,
            to_s: 2.0,
            lost_samples,
            reason: "late".into(),
        };
        let said = losses(&[gap(Some(0)), gap(Some(3))], 0);
        assert_eq!(
            said,
            [
                "probe-1: nothing from 1.00 s to 2.00 s (late)",
                "probe-1: nothing from 1.00 s to 2.00 s, 3 samples missing (late)"
            ]
        );
    }
}
