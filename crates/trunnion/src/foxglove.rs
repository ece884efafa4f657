//! A recording for 3D viewers (Foxglove, Lichtblick): the machine as it moved, the ball, the errors as magnified arrows, events.

mod errors;
mod moved;
mod scene;

use crate::{Error, Fit, files};
use std::path::Path;
use trunnion_core::Quality;
use trunnion_record::foxglove::FoxgloveWriter;
use trunnion_record::{Item, RecordError};

/// An arrangement of panels for these topics, to be imported in the viewer.
pub const LAYOUT: &str = include_str!("foxglove/layout.json");

/// What was written.
pub struct Written {
    /// How many times the arrows are as long as the errors; `None` without arrows.
    pub magnification: Option<f64>,
    /// What is wrong with the recording.
    pub damage: Option<String>,
}

/// Writes the file `output` of one recording; the arrows are those of its fit, where there is one. They are magnified so that the
/// largest is visible, or as asked.
///
/// # Errors
/// A recording that cannot be read, or a file that cannot be written.
pub fn export(
    recording: &Path,
    output: &Path,
    fit: Option<&Fit>,
    magnification: Option<f64>,
) -> Result<Written, Error> {
    let not_read = Error::recording(recording);
    let not_written = Error::not_recorded(output);
    files::may_be_replaced(output)?;
    let header = trunnion_record::read_header(recording).map_err(not_read)?;
    let named = || files::machine(&header.machine_name);
    let machine = header.machine().and_then(Result::ok).map_or_else(named, Ok)?;
    let mut writer =
        FoxgloveWriter::create(output, &header, env!("CARGO_PKG_VERSION")).map_err(not_written)?;

    scene::setups(&mut writer, &header.setups).map_err(not_written)?;
    let mut moved = moved::Moved::new(&machine, &header.setups);
    let (mut points, mut failed) = (0, None);
    let mut draw = |item: Item| -> Result<(), RecordError> {
        match item {
            Item::Axes(sample) => moved.axes(&mut writer, &sample),
            Item::Point(point) if point.quality == Quality::Good => {
                let time_s = scene::shown_s(point.state.time_s, points);
                points += 1;
                moved.point(&mut writer, time_s, &point.state)
            }
            Item::Event(event) => scene::event(&mut writer, &event),
            Item::Gap(gap) => scene::gap(&mut writer, &gap),
            Item::Point(_) | Item::Probe(_) | Item::Temperature(_) => Ok(()),
        }
    };
    let visited = trunnion_record::visit(recording, &mut |item| {
        failed = draw(item).err();
        failed.is_none()
    });
    let (_, damage) = visited.map_err(not_read)?;
    if let Some(error) = failed {
        return Err(not_written(error));
    }
    let damage = damage.map(|damage| format!("{}: {damage}", recording.display()));
    if let Some(damage) = &damage {
        scene::damage(&mut writer, damage).map_err(not_written)?;
    }
    let magnification = match fit {
        Some(fit) => Some(errors::arrows(&mut writer, &fit.residuals(), magnification).map_err(not_written)?),
        None => None,
    };
    writer.finish().map_err(not_written)?;
    Ok(Written { magnification, damage })
}
