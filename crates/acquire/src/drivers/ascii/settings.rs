//! The keys of the `ascii` driver: a preset, changed where the keys say so.

use crate::bar_zero;
use crate::driver::Device;
use crate::transport::serial::Framing;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::Role;
use trunnion_core::input::Table;
use trunnion_protocol::ascii::{Format, PRESETS, Pattern, Preset, Stamp, Unit};

const CUSTOM: &str = "custom";

const STAMPS: [(&str, Stamp); 3] =
    [("request", Stamp::Request), ("between", Stamp::Between), ("arrival", Stamp::Arrival)];

/// One configured indicator.
#[derive(Debug)]
pub(super) struct Settings {
    pub port: String,
    pub preset: String,
    pub role: Role,
    pub bar_zero_mm: Option<f64>,
    pub baud: u32,
    pub framing: Framing,
    pub poll: Duration,
    pub stamp: Stamp,
    pub format: Format,
    pub unconfirmed: &'static str,
}

impl Settings {
    /// The kind of device, for messages.
    pub fn shown(&self) -> String {
        let about = Preset::named(&self.preset).map_or("the configured pattern", |preset| preset.about);
        format!("{} ({about}), in {}", self.preset, self.format.unit.name())
    }

    /// The request, readable.
    pub fn shown_request(&self) -> String {
        String::from_utf8_lossy(&self.format.request).escape_default().to_string()
    }
}

pub(super) fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let port = table.string("port");
    let role = Role::read(table);
    let bar_zero_mm = bar_zero::read(table, role);
    let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).chain([CUSTOM]).collect();
    let name = table.one_of("preset", &names);
    let known = name.as_deref().and_then(Preset::named);
    let custom = name.is_some() && known.is_none();

    let baud =
        table.optional_number("baud", 110.0..=921_600.0).or(known.map(|preset| f64::from(preset.baud)));
    if custom && !table.has("baud") {
        table.problem("baud", "is missing", "a number", "The preset \"custom\" knows no line speed.");
    }
    let framing =
        Framing::read(table).or_else(|| Some(framing_named(known.map_or("8N1", |preset| preset.framing))));
    let poll_ms = table.optional_number("poll_ms", 1.0..=60_000.0);
    let unit = read_unit(table, role).or(known.map(|preset| preset.unit));
    let stamp = table.optional_one_of("stamp", &STAMPS.map(|(name, _)| name));
    let mut format = match known {
        Some(preset) => Some(preset.format()),
        None if custom => read_format(table),
        None => None,
    };
    if let Some(request) = table.optional_string("request")
        && let Some(format) = &mut format
    {
        format.request = request.into_bytes();
    }
    if custom && unit.is_none() && !table.has("unit") {
        table.problem("unit", "is missing", "mm, um, inch, degC", "");
    }
    let (framing, unit, mut format) = (framing?, unit?, format?);
    if role == Some(Role::Temperature) && unit.length_mm().is_some() && !table.has("unit") {
        table.problem("unit", "is missing for a temperature", "degC", "");
    }
    format.unit = unit;
    format.seven_bits = framing.seven_bits;
    let asked = !format.request.is_empty();
    let usual_stamp =
        known.map_or(if asked { Stamp::Between } else { Stamp::Arrival }, |preset| preset.stamp);
    let stamp =
        stamp.and_then(|name| STAMPS.iter().find(|(known, _)| *known == name)).map(|(_, stamp)| *stamp);
    Some(Arc::new(Settings {
        port: port?,
        preset: name?,
        role: role?,
        bar_zero_mm,
        baud: baud? as u32,
        framing,
        poll: Duration::from_secs_f64(poll_ms.or(known.map(|preset| preset.poll_ms)).unwrap_or(100.0) / 1e3),
        stamp: stamp.unwrap_or(usual_stamp),
        format,
        unconfirmed: known.map_or("", |preset| preset.unconfirmed),
    }))
}

/// The framing of a preset.
pub(super) fn framing_named(usual: &str) -> Framing {
    Framing::NAMES.iter().find(|(name, _)| *name == usual).map_or(Framing::PLAIN, |(_, framing)| *framing)
}

/// The key `unit`, which must fit the role.
fn read_unit(table: &Table<'_>, role: Option<Role>) -> Option<Unit> {
    let text = table.optional_one_of("unit", &Unit::NAMES.map(|(name, _)| name))?;
    let unit = Unit::NAMES.iter().find(|(name, _)| *name == text).map(|(_, unit)| *unit)?;
    let is_temperature = unit.length_mm().is_none();
    if role.is_some_and(|role| (role == Role::Temperature) != is_temperature) {
        let allowed = if is_temperature { "mm, um, inch" } else { "degC" };
        table.problem("unit", format!("= \"{text}\" does not fit the role"), allowed, "");
    }
    Some(unit)
}

fn read_format(table: &Table<'_>) -> Option<Format> {
    let text = table.string("pattern")?;
    let errors = table.optional_strings("errors").unwrap_or_default();
    let pattern = text.parse::<Pattern>().map_err(|error| {
        table.problem("pattern", format!("= \"{text}\""), error, "");
    });
    Some(Format {
        pattern: pattern.ok()?,
        unit: Unit::Millimetre,
        errors: errors.into_iter().map(|word| (word, "the device reports an error".into())).collect(),
        seven_bits: false,
        request: Vec::new(),
    })
}

/// The number in a line without value ("ERR3" is 3), or the place of its word in the list.
pub(super) fn error_code(text: &str, index: usize) -> i64 {
    let digits: String =
        text.chars().rev().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
    let number = digits.chars().rev().collect::<String>().parse().ok();
    number.filter(|_| digits.len() <= 6).unwrap_or(index as i64)
}
