//! A program in no dialect: what every controller can be asked.

use trunnion_core::Joint;

/// Axes with their positions as people write them, mm and degrees.
pub type Target = Vec<(Joint, f64)>;

/// An NC program.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Name of the cycle.
    pub name: String,
    /// What the operator reads before starting.
    pub header: Vec<String>,
    /// How far a control that rounds corners may leave the programmed points, mm.
    pub tolerance_mm: f64,
    /// True where the control keeps the tool point over the table (TCP, TRAORI, M128).
    pub tool_point: bool,
    /// Everything in order.
    pub blocks: Vec<Block>,
    /// Running time without stops, s.
    pub duration_s: f64,
    /// Shortest block of a sweep, s; `None` without sweep.
    pub shortest_block_s: Option<f64>,
    /// Number of the program, in dialects whose programs have numbers; `None`: it follows from the name.
    pub number: Option<u32>,
}

/// A running time as it is shown: the next whole minute, so that nobody is early.
pub fn whole_minutes(duration_s: f64) -> u32 {
    (duration_s / 60.0).ceil() as u32
}

/// One instruction.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Words for a reader of the program.
    Remark(String),
    /// The machine waits for the operator, who reads this.
    Stop(String),
    /// Tool centre point control on or off; nothing moves. Positions after that are of the tool point over the table, by the linear axes with
    /// the rotary axes at zero.
    ToolPoint(bool),
    /// Straight; only linear or only rotary axes move.
    Feed {
        /// The axes that may move and where to, mm or degrees.
        to: Target,
        /// mm or degrees a minute.
        per_min: f64,
    },
    /// Straight in the space of all axes, in a given time.
    Timed {
        /// The axes that may move and where to, mm and degrees.
        to: Target,
        /// How long it takes, s.
        seconds: f64,
    },
    /// Standing still.
    Dwell {
        /// How long, s.
        seconds: f64,
    },
}
