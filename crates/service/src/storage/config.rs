//! What the folder of the recordings may take.

use std::time::Duration;
use trunnion_core::input::Table;

pub(super) const DAY: Duration = Duration::from_secs(24 * 3600);

/// What the folder may take: `[storage]` of the configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StorageConfig {
    /// Left free for the rest of the computer, MB.
    pub keep_free_mb: f64,
    /// All raw recordings together, MB; no limit without it.
    pub budget_mb: Option<f64>,
    /// Raw recordings older than this are removed; none without it.
    pub keep: Option<Duration>,
}

impl Default for StorageConfig {
    /// A file system without 500 MB stops other programs: journald alone keeps 15 % free up to 4 GB (journald.conf(5),
    /// `SystemKeepFree`). Nothing is removed that a person did not allow.
    fn default() -> Self {
        Self { keep_free_mb: 500.0, budget_mb: None, keep: None }
    }
}

impl StorageConfig {
    /// Reads `[storage]`.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let usual = Self::default();
        let keep_free_mb = table.optional_number("keep_free_mb", 0.0..=1e9);
        let budget_mb = table.optional_number("budget_mb", 1.0..=1e9);
        let keep_days = table.optional_number("keep_days", 0.01..=1e5);
        table.no_other_keys();
        let keep = keep_days.map(|days| DAY.mul_f64(days));
        Some(Self { keep_free_mb: keep_free_mb.unwrap_or(usual.keep_free_mb), budget_mb, keep })
    }
}

/// MB of bytes.
pub(super) fn mb(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
