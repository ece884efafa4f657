//! What a measurement must have for an effect to show, as data: for reasons why an effect is out of reach, and for
//! planning the cycle that brings it within reach.

use crate::subjects::{axis_of, rotary_below};
use crate::{Scene, Subject};
use trunnion_core::Joint;

/// One thing a cycle or a recording can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Need {
    /// The axis stands at more than one position.
    Travel,
    /// The axis comes from both directions.
    BothDirections,
    /// Readings are taken while the axis (for the whole machine: any axis) moves.
    OnTheFly,
    /// The speed of the axis changes between or during readings.
    ChangingSpeed,
    /// The axis is read both at rest and in motion.
    RestAndMotion,
    /// A motion that changes the distance of ball and nest, or moves linear and rotary axes together.
    DelayShows,
    /// The rotary axis that carries this one stands at several tilts.
    SeveralTilts,
    /// A rotary axis between ball and nest moves, so that the probes touch other places of the ball.
    BallTurns,
    /// An instrument that reads x, y and z.
    ThreeComponents,
    /// The probes are deflected.
    Deflection,
    /// Points carry their time.
    TimeStamps,
    /// A temperature channel that changes.
    Temperature,
    /// Balls at two heights above the table.
    TwoHeights,
    /// Balls at two distances from the axis.
    TwoRadii,
    /// Two feeds.
    TwoFeeds,
    /// A finer step of the poses, or readings on the fly.
    FinerStep,
    /// Another load on the table.
    AnotherLoad,
    /// A return to the first pose, or a wait and a repeat.
    Return,
    /// Many places of the axis while the rotary axes stand at one pose.
    Volume,
    /// An artefact with several targets.
    Targets,
    /// The ball moved by known steps (nest calibration).
    KnownSteps,
}

impl Need {
    /// Every need.
    pub const ALL: [Self; 21] = [
        Self::Travel,
        Self::BothDirections,
        Self::OnTheFly,
        Self::ChangingSpeed,
        Self::RestAndMotion,
        Self::DelayShows,
        Self::SeveralTilts,
        Self::BallTurns,
        Self::ThreeComponents,
        Self::Deflection,
        Self::TimeStamps,
        Self::Temperature,
        Self::TwoHeights,
        Self::TwoRadii,
        Self::TwoFeeds,
        Self::FinerStep,
        Self::AnotherLoad,
        Self::Return,
        Self::Volume,
        Self::Targets,
        Self::KnownSteps,
    ];

    /// In words for a person who prepares a cycle.
    pub fn text(self) -> &'static str {
        match self {
            Self::Travel => "several positions of the axis",
            Self::BothDirections => "both directions of the axis",
            Self::OnTheFly => "readings on the fly",
            Self::ChangingSpeed => "a speed that changes, or two feeds",
            Self::RestAndMotion => "readings of the axis both at rest and in motion",
            Self::DelayShows => {
                "linear and rotary axes moving together, or a motion that changes the distance of ball and nest"
            }
            Self::SeveralTilts => "several tilts of the axis below",
            Self::BallTurns => "a rotary axis between ball and nest that moves",
            Self::ThreeComponents => "an R-test (x, y, z)",
            Self::Deflection => "probes that are deflected",
            Self::TimeStamps => "time stamps",
            Self::Temperature => "a temperature channel that changes",
            Self::TwoHeights => "two heights of the ball",
            Self::TwoRadii => "two distances of the ball from the axis",
            Self::TwoFeeds => "two feeds",
            Self::FinerStep => "a finer step of the poses, or readings on the fly",
            Self::AnotherLoad => "another load on the table or in the head",
            Self::Return => "a return to the first pose, or a wait and a repeat",
            Self::Volume => "five places of the axis or more while the rotary axes are stationary",
            Self::Targets => "an artefact with several targets",
            Self::KnownSteps => "known steps of the ball (nest calibration)",
        }
    }

    /// True for what an effect acts on: where one direction of it is zero, what acts on that is too.
    pub(crate) fn is_acted_on(self) -> bool {
        matches!(self, Self::Deflection | Self::DelayShows)
    }

    /// Whether the data of a scene have it for this subject; `None` when the data do not show it.
    pub fn met(self, scene: &Scene, subject: Subject) -> Option<bool> {
        let of_axis = |test: &dyn Fn(Joint) -> bool| match subject {
            Subject::Axis(letter) | Subject::Pair(letter, _) => test(letter),
            Subject::Whole => scene.machine.axes().any(|axis| test(axis.letter)),
        };
        let balls = || scene.setups.iter().map(|setup| setup.ball_in_table_mm);
        let differ = |values: Vec<f64>| {
            values.iter().any(|value| (value - values.first().unwrap_or(value)).abs() > 1.0)
        };
        Some(match self {
            Self::Travel => of_axis(&|letter| scene.moves(letter)),
            Self::BothDirections => of_axis(&|letter| scene.both_directions(letter)),
            Self::OnTheFly => of_axis(&|letter| scene.read_in_motion(letter)),
            Self::ChangingSpeed => of_axis(&|letter| {
                scene.accelerates(letter) || (letter.is_rotary() && scene.changes_speed(letter))
            }),
            Self::RestAndMotion => of_axis(&|letter| scene.rests_and_moves(letter)),
            Self::DelayShows => scene.path.changes_reading || scene.path.linear_with_rotary,
            Self::SeveralTilts => axis_of(&scene.machine, subject)
                .and_then(|axis| rotary_below(&scene.machine, axis.letter))
                .is_some_and(|below| scene.moves(below.letter)),
            Self::BallTurns => scene.machine.rotary().iter().any(|axis| scene.moves(axis.letter)),
            Self::ThreeComponents => scene.setups.iter().any(|setup| setup.components.len() == 3),
            Self::Deflection => scene.deflection_mm.amax() > 1e-9,
            Self::TimeStamps => scene.has_time(),
            Self::Temperature => !scene.varying_channels().is_empty(),
            Self::TwoHeights => differ(balls().map(|ball| ball.z).collect()),
            Self::TwoRadii => differ(balls().map(|ball| ball.x.hypot(ball.y)).collect()),
            Self::TwoFeeds => of_axis(&|letter| scene.two_feeds(letter)),
            Self::Volume => of_axis(&|letter| scene.measures_volume(letter)),
            Self::Targets => scene
                .setups
                .iter()
                .any(|setup| setup.artefact.as_ref().is_some_and(|artefact| artefact.targets.len() > 1)),
            Self::FinerStep | Self::AnotherLoad | Self::Return | Self::KnownSteps => return None,
        })
    }
}
