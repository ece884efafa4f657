//! Acquisition: from ports and networks to points.
//!
//! Two halves with a wall between them. The live half talks to devices: [`config`] says which, [`drivers`] holds one
//! *session* per kind (opens, identifies, reads, never retries), [`supervisor`] keeps all of them alive and sends
//! [`Message`]s through one bounded queue. The pure half turns readings into points and is shared with replay:
//! [`timebase`] (device clocks to run time), [`align`] (probes and axes to common instants), [`static_cycle`] and
//! [`sweep_cycle`] (points), [`nest`] (probe calibration). Nothing in the pure half asks a clock, so a recording
//! gives the same points as the live run. [`cycle_bounds`] tells from the readings when a cycle begins and ends.

pub mod align;
pub mod clock;
pub mod config;
pub mod cycle_bounds;
pub mod discovery;
pub mod drivers;
pub mod gesture;
pub mod message;
pub mod nest;
pub mod probe;
pub mod retime;
pub mod static_cycle;
pub mod supervisor;
pub mod sweep_cycle;
pub mod timebase;
pub mod transport;

pub use align::{AlignLimits, Aligned, AlignedSample, Aligner, AxisState};
pub use clock::{ClockLine, ClockTrack, Jump};
pub use config::{Channel, DeviceConfig, Role, parse_devices, read_devices};
pub use cycle_bounds::{Bound, CycleBounds, StartRule};
pub use gesture::{GestureFinder, MeanDelay, mean_delays};
pub use message::{
    AxisReading, ControllerReading, Counters, Execution, LogLine, Message, ProbeReading, Reading, SourceGap,
    TemperatureReading,
};
pub use nest::NestCalibration;
pub use retime::{Retiming, Stream, Survey};
pub use static_cycle::{CycleEvent, EndReason, Progress, StaticCycle, StaticRules};
pub use supervisor::{Acquisition, DeviceState, DeviceStatus, SessionEnd, start};
pub use sweep_cycle::{SweepCycle, SweepRules};
pub use timebase::{TimeBase, Timed};
