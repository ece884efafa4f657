//! What stands in the scene, and what happened: balls of the setups, events and gaps.

use nalgebra::UnitQuaternion;
use trunnion_core::{Event, Gap, Setup};
use trunnion_record::RecordError;
use trunnion_record::foxglove::messages::log::Level;
use trunnion_record::foxglove::messages::{
    self, Color, KeyValuePair, Log, SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive,
};
use trunnion_record::foxglove::{Channel, FoxgloveWriter, metres, pose, vector};

pub const SCENE: Channel = Channel { topic: "/scene", schema: "foxglove.SceneUpdate" };
pub const LOG: Channel = Channel { topic: "/log", schema: "foxglove.Log" };
pub const EVENTS: Channel = Channel { topic: "/events", schema: "foxglove.Event" };

/// Drawn size of a ball and of a letter, mm: a common ball of an R-test.
const BALL_MM: f64 = 22.0;
const BALL: Color = Color { r: 0.75, g: 0.75, b: 0.8, a: 1.0 };
const LETTER: Color = Color { r: 0.1, g: 0.1, b: 0.1, a: 1.0 };

/// The balls of every setup, on the table and at the tool.
pub fn setups(writer: &mut FoxgloveWriter, setups: &[Setup]) -> Result<(), RecordError> {
    let mut entities = Vec::new();
    for setup in setups {
        let targets = (0..setup.targets()).map(|target| setup.target_in_table_mm(target)).collect();
        for (frame, places) in [("table", targets), ("tool", vec![setup.ball_in_tool_mm])] {
            let here = |place: &nalgebra::Point3<f64>| Some(pose(place, &UnitQuaternion::identity()));
            let sphere = |place: &nalgebra::Point3<f64>| SpherePrimitive {
                pose: here(place),
                size: Some(vector(&nalgebra::Vector3::repeat(BALL_MM))),
                color: Some(BALL),
            };
            let name = |place: &nalgebra::Point3<f64>| TextPrimitive {
                pose: here(place),
                billboard: true,
                font_size: metres(BALL_MM),
                scale_invariant: false,
                color: Some(LETTER),
                text: setup.name.clone(),
            };
            entities.push(SceneEntity {
                timestamp: Some(writer.moment(0.0)),
                frame_id: frame.into(),
                id: format!("{} at the {frame}", setup.name),
                frame_locked: true,
                metadata: metadata(&[("setup", &setup.name), ("instrument", setup.instrument.name())]),
                spheres: places.iter().map(sphere).collect(),
                texts: if frame == "table" { places.iter().map(name).collect() } else { Vec::new() },
                ..SceneEntity::default()
            });
        }
    }
    writer.write(SCENE, 0.0, &SceneUpdate { entities, deletions: Vec::new() })
}

/// Something that happened, as a line of the log and as an event.
pub fn event(writer: &mut FoxgloveWriter, event: &Event) -> Result<(), RecordError> {
    log(writer, event.time_s, Level::Info, &event.kind, &event.text)?;
    let of_event = metadata(&[("kind", &event.kind), ("text", &event.text)]);
    span(writer, (event.time_s, event.time_s), of_event)
}

/// A gap, as a warning of the log and as an event of its duration.
pub fn gap(writer: &mut FoxgloveWriter, gap: &Gap) -> Result<(), RecordError> {
    let text = crate::page::losses(std::slice::from_ref(gap), 0).join(" ");
    log(writer, gap.from_s, Level::Warning, &gap.source, &text)?;
    span(writer, (gap.from_s, gap.to_s), metadata(&[("kind", "gap"), ("text", &text)]))
}

/// What is wrong with the recording.
pub fn damage(writer: &mut FoxgloveWriter, text: &str) -> Result<(), RecordError> {
    log(writer, 0.0, Level::Error, "recording", text)
}

fn log(
    writer: &mut FoxgloveWriter,
    time_s: f64,
    level: Level,
    name: &str,
    message: &str,
) -> Result<(), RecordError> {
    let line = Log {
        timestamp: Some(writer.moment(time_s)),
        level: level.into(),
        message: message.into(),
        name: name.into(),
        ..Log::default()
    };
    writer.write(LOG, time_s, &line)
}

fn span(
    writer: &mut FoxgloveWriter,
    (from_s, to_s): (f64, f64),
    metadata: Vec<KeyValuePair>,
) -> Result<(), RecordError> {
    let (start_time, end_time) = (Some(writer.moment(from_s)), Some(writer.moment(to_s)));
    writer.write(EVENTS, from_s, &messages::Event { start_time, end_time, metadata })
}

/// When a point is shown, s: where the run has no time stamps, a point a second.
pub fn shown_s(time_s: Option<f64>, index: usize) -> f64 {
    time_s.unwrap_or(index as f64)
}

pub fn metadata(pairs: &[(&str, &str)]) -> Vec<KeyValuePair> {
    pairs.iter().map(|(key, value)| KeyValuePair { key: (*key).into(), value: (*value).into() }).collect()
}
