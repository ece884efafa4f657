//! From samples to points: clocks, alignment, static and on-the-fly forming, blocks, stations, time quality.
//!
//! Shared by live runs and replay. Nothing here asks a clock, so a recording gives the same points as the live run.
//! [`timebase`] brings device clocks to run time, [`align`] brings probes and axes to common instants, [`static_cycle`]
//! and [`sweep_cycle`] form points, [`nest`] calibrates probes, [`jog`] checks them, [`cycle_bounds`] finds when a cycle begins and ends.

pub mod align;
pub mod blocks;
pub mod clock;
pub mod cycle_bounds;
mod cycle_event;
pub mod forming;
mod interval;
pub mod jog;
pub mod nest;
pub mod plan;
pub mod retime;
pub mod static_cycle;
pub mod stations;
pub mod sweep_cycle;
pub mod sync_move;
pub mod time_quality;
pub mod timebase;

pub use align::{AlignLimits, Aligned, Aligner, AxisState};
pub use clock::{ClockLine, ClockTrack, Jump};
pub use cycle_bounds::{Bound, CycleBounds, StartRule};
pub use cycle_event::{CycleEvent, EndReason, Progress};
pub use nest::NestCalibration;
pub use retime::{Retiming, RetimingFit, Stream};
pub use static_cycle::{DwellReader, DwellReading, StandsAt, StaticCycle, StaticRules};
pub use sweep_cycle::{Course, SampleCounts, SweepCycle, SweepRules, at_feed};
pub use sync_move::{MeanDelay, SyncMoveFinder, mean_delays};
pub use timebase::{TimeBase, Timed};
