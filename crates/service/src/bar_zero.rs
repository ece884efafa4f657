//! A calibrated length asks of the configuration what the bar shows at that length.

use crate::config::Config;
use trunnion::cycles::Cycle;
use trunnion_acquire::config::channels;
use trunnion_core::{InstrumentKind, Role};

/// A cycle takes the length of the bar itself, and nobody says from where the bar counts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "cycle {cycle} takes the length of the bar itself (setup {setup}: calibrated = true), but {file} does not say what {channel} shows at that \
     length: every reading would be off by it. Put the bar on its calibrator, and give what it shows there, less the length of the calibrator over \
     bar_length_mm ({length_mm} mm), as zero_mm of {channel}, such as zero_mm = 10.0; zero_mm = 0.0 where the device itself was set to zero there"
)]
pub struct NoBarZero {
    /// The cycle.
    pub cycle: String,
    /// Its first setup with a calibrated bar.
    pub setup: String,
    /// The length there, mm.
    pub length_mm: f64,
    /// The configuration.
    pub file: String,
    /// Name of the channel of the bar.
    pub channel: String,
}

/// Checks that a configuration says from where the bar counts, where a cycle needs it.
///
/// # Errors
/// When it does not.
pub fn check(config: &Config, cycle: &Cycle) -> Result<(), NoBarZero> {
    let is_asked = |setup: &&trunnion_core::Setup| {
        setup.instrument == InstrumentKind::BallBar && setup.reads_calibrated_length()
    };
    let Some(setup) = cycle.setups.iter().find(is_asked) else { return Ok(()) };
    let channels = channels(&config.devices);
    // Without a bar there is another error.
    let Some(bar) = channels.iter().find(|channel| channel.role == Role::Bar) else { return Ok(()) };
    if config.devices[usize::from(bar.device)].device.bar_zero_mm().is_some() {
        return Ok(());
    }
    Err(NoBarZero {
        cycle: cycle.name.clone(),
        setup: setup.name.clone(),
        length_mm: setup.bar_length_mm.unwrap_or_default(),
        file: config.file.display().to_string(),
        channel: bar.name.clone(),
    })
}
