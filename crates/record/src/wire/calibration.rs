//! What the certificate of a sensor says, in a header.

use crate::schema as pb;
use trunnion_core::{Calibration, Day};

pub(super) fn encode(calibration: &Calibration) -> pb::Calibration {
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let day = |day: Option<Day>| day.map(|day| day.to_string()).unwrap_or_default();
    pb::Calibration {
        sensor: calibration.sensor.clone(),
        serial: text(&calibration.serial),
        certificate: text(&calibration.certificate),
        laboratory: text(&calibration.laboratory),
        date: day(calibration.date),
        valid_until: day(calibration.valid_until),
    }
}

/// `None` for a day that no calendar has.
pub(super) fn decode(message: pb::Calibration) -> Option<Calibration> {
    let text = |text: String| (!text.is_empty()).then_some(text);
    let day = |text: String| if text.is_empty() { Some(None) } else { Day::parse(&text).map(Some) };
    Some(Calibration {
        sensor: message.sensor,
        serial: text(message.serial),
        certificate: text(message.certificate),
        laboratory: text(message.laboratory),
        date: day(message.date)?,
        valid_until: day(message.valid_until)?,
    })
}
