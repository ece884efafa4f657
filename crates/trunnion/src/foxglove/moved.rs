//! The machine as it moved: a frame for every component, the joints, the pose of the ball.

use trunnion_core::{AxisSample, AxisValues, Setup, State};
use trunnion_machine::Machine;
use trunnion_record::RecordError;
use trunnion_record::foxglove::messages::{FrameTransforms, JointState, JointStates, PoseInFrame};
use trunnion_record::foxglove::{Channel, FoxgloveWriter, metres, pose, transform};

pub const FRAMES: Channel = Channel { topic: "/tf", schema: "foxglove.FrameTransforms" };
pub const JOINTS: Channel = Channel { topic: "/joint_states", schema: "foxglove.JointStates" };
pub const BALL: Channel = Channel { topic: "/ball", schema: "foxglove.PoseInFrame" };

/// Shortest time between two pictures, s: what a screen of 60 Hz shows.
const PICTURE_S: f64 = 1.0 / 60.0;

/// Draws the machine where it was.
pub struct Moved<'r> {
    machine: &'r Machine,
    setups: &'r [Setup],
    /// When the last picture was drawn from samples of the axes; without any, points draw it.
    drawn_s: Option<f64>,
    /// The targets whose pose was written last.
    target: Option<(usize, usize)>,
}

impl<'r> Moved<'r> {
    pub fn new(machine: &'r Machine, setups: &'r [Setup]) -> Self {
        Self { machine, setups, drawn_s: None, target: None }
    }

    /// Positions of the axes.
    pub fn axes(&mut self, writer: &mut FoxgloveWriter, sample: &AxisSample) -> Result<(), RecordError> {
        if self.drawn_s.is_some_and(|drawn_s| sample.time_s - drawn_s < PICTURE_S) {
            return Ok(());
        }
        self.drawn_s = Some(sample.time_s);
        self.draw(writer, sample.time_s, &sample.position)
    }

    /// A point: the ball that was measured, and without samples of the axes the machine too.
    pub fn point(
        &mut self,
        writer: &mut FoxgloveWriter,
        time_s: f64,
        state: &State,
    ) -> Result<(), RecordError> {
        if self.drawn_s.is_none() {
            self.draw(writer, time_s, &state.position)?;
        }
        let measured = (state.setup, state.target);
        let Some(setup) = self.setups.get(state.setup).filter(|_| self.target != Some(measured)) else {
            return Ok(());
        };
        self.target = Some(measured);
        let ball = PoseInFrame {
            timestamp: Some(writer.moment(time_s)),
            frame_id: "table".into(),
            pose: Some(pose(&setup.target_in_table_mm(state.target), &nalgebra::UnitQuaternion::identity())),
        };
        writer.write(BALL, time_s, &ball)
    }

    fn draw(
        &self,
        writer: &mut FoxgloveWriter,
        time_s: f64,
        position: &AxisValues<f64>,
    ) -> Result<(), RecordError> {
        let moment = writer.moment(time_s);
        let links = self.machine.links(position);
        let frame = |link: &trunnion_machine::Link| {
            transform(moment, (&link.carrier, &link.carried), &link.carrier_from_carried)
        };
        let transforms = links.iter().map(frame).collect();
        writer.write(FRAMES, time_s, &FrameTransforms { transforms })?;
        let joints = self.machine.joints().into_iter().map(|joint| {
            let inside = position[joint];
            let position = Some(if joint.is_rotary() { inside } else { metres(inside) });
            JointState { name: joint.to_string(), position, ..JointState::default() }
        });
        writer.write(JOINTS, time_s, &JointStates { timestamp: Some(moment), joints: joints.collect() })
    }
}
