//! The delay of each channel over all synchronisation moves of a run: weighted means.
//! τ = Σ τᵢ uᵢ⁻² / Σ uᵢ⁻², u = R/√(Σ uᵢ⁻²), R² = max(1, Σ ((τᵢ − τ)/uᵢ)² / (n − 1))        [Birge, Phys. Rev. 40 (1932) 207]
//! Where the synchronisation moves differ by more than they should, the uncertainty holds that too.

use crate::time_quality::SyncMove;
use std::collections::BTreeMap;

/// Delay of one channel against the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanDelay {
    /// By how much the readings come after the axes, s.
    pub delay_s: f64,
    /// Its standard uncertainty, s.
    pub u_s: f64,
    /// Birge's ratio R: by how many times their uncertainties the synchronisation moves differ; at least 1.
    pub birge_ratio: f64,
}

/// The delays of all channels seen.
pub fn mean_delays(sync_moves: &[SyncMove]) -> BTreeMap<u16, MeanDelay> {
    let mut seen: BTreeMap<u16, Vec<(f64, f64)>> = BTreeMap::new();
    for delay in sync_moves.iter().flat_map(|sync_move| &sync_move.seen) {
        seen.entry(delay.channel).or_default().push((delay.delay_s, delay.u_s));
    }
    seen.into_iter().map(|(channel, delays)| (channel, weighted_mean(&delays))).collect()
}

fn weighted_mean(delays: &[(f64, f64)]) -> MeanDelay {
    let weight: f64 = delays.iter().map(|(_, u)| u.powi(-2)).sum();
    let delay_s = delays.iter().map(|(delay, u)| delay * u.powi(-2)).sum::<f64>() / weight;
    let chi_square: f64 = delays.iter().map(|(delay, u)| ((delay - delay_s) / u).powi(2)).sum();
    let birge_ratio = (chi_square / (delays.len() as f64 - 1.0).max(1.0)).max(1.0).sqrt();
    MeanDelay { delay_s, u_s: birge_ratio / weight.sqrt(), birge_ratio }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time_quality::SyncMoveDelay;
    use trunnion_core::Joint;

    fn sync_move(delay_s: f64) -> SyncMove {
        let seen = vec![SyncMoveDelay { channel: 2, delay_s, u_s: 10e-6, gain: 0.8, rms_mm: 3e-4 }];
        SyncMove { time_s: 0.0, axis: Joint::X, stroke_mm: 0.2, seen }
    }

    #[test]
    fn sync_moves_are_averaged_and_a_changed_delay_shows_in_the_uncertainty() {
        let steady = mean_delays(&[sync_move(1.00e-3), sync_move(1.01e-3)])[&2];
        assert!((steady.delay_s - 1.005e-3).abs() < 1e-9 && steady.birge_ratio == 1.0);
        assert!((steady.u_s - 7.07e-6).abs() < 0.1e-6);
        let changed = mean_delays(&[sync_move(1.0e-3), sync_move(2.0e-3)])[&2];
        assert!(changed.birge_ratio > 50.0 && changed.u_s > 400e-6);
    }
}
