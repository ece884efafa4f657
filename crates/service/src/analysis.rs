//! Who analyses, and what an analysis is given: a model, time, memory.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;
use trunnion::Model;
use trunnion_core::input::Table;

/// Who analyses.
#[derive(Clone, Debug)]
pub enum Analyst {
    /// This process, without limits.
    Here,
    /// This program, as a process of its own with limits of time and memory.
    Program(PathBuf),
}

/// What one analysis may take: `[analysis]` of the configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalysisLimits {
    /// Time.
    pub time: Duration,
    /// Memory, MB.
    pub memory_mb: f64,
    /// Analyses of one run that may fail.
    pub tries: u32,
}

impl Default for AnalysisLimits {
    /// A run of 336 points takes 3 s and between 64 and 200 MB on two busy cores (test `service_killed`). A run on the fly is reduced to 2000 blocks,
    /// whose three readings each make a dense matrix of 288 MB: there is room for ten. What fails by chance (power, a computer without
    /// memory) with a probability of one in ten remains once in a thousand runs after three tries; what fails by its data fails each time.
    fn default() -> Self {
        Self { time: Duration::from_secs(1800), memory_mb: 4096.0, tries: 3 }
    }
}

impl AnalysisLimits {
    /// Allowed times, s. Less than the analysis of the smallest cycle takes would fail every run.
    pub const TIME_S: RangeInclusive<f64> = 1.0..=86_400.0;
    /// Allowed memory, MB; the least as of the time.
    pub const MEMORY_MB: RangeInclusive<f64> = 64.0..=1e6;

    /// Reads `[analysis]`.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let usual = Self::default();
        let time_s = table.optional_number("time_s", Self::TIME_S);
        let memory_mb = table.optional_number("memory_mb", Self::MEMORY_MB);
        let tries = table.optional_number("tries", 1.0..=100.0);
        table.no_other_keys();
        Some(Self {
            time: time_s.map_or(usual.time, Duration::from_secs_f64),
            memory_mb: memory_mb.unwrap_or(usual.memory_mb),
            tries: tries.map_or(usual.tries, |tries| tries as u32),
        })
    }
}

/// What a run is judged by.
#[derive(Clone, Debug, Default)]
pub struct JudgedBy {
    /// The model; the base model without it.
    pub model: Option<Model>,
    /// The file it was read from.
    pub file: Option<PathBuf>,
}
