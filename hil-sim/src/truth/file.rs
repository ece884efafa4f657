//! The sealed truth file, `format = "trunnion-truth/1"`. The program under test never reads it.

use super::location::LocationError;
use super::{Instrument, NamedError, NestOn, Noise, PlacedSetup, SimSetup, Truth};
use crate::physics::hidden;
use crate::physics::hidden::Hidden;
use nalgebra::Point3;
use std::ops::RangeInclusive;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, value};
use trunnion_core::convert::{mm_from_um, rad_from_urad, um_from_mm, urad_from_rad};
use trunnion_core::input::{Document, Table};
use trunnion_core::{InstrumentKind, Joint, Problems, names};
use trunnion_machine::JointErrors;

const FORMAT: &str = "trunnion-truth/1";
const ANY: RangeInclusive<f64> = -1e12..=1e12;
const SIZE: RangeInclusive<f64> = 0.0..=1e6;
const DURATION_S: RangeInclusive<f64> = 1e-3..=1e9;

impl Truth {
    /// The truth file.
    pub fn to_toml(&self) -> String {
        let mut file = DocumentMut::new();
        file["format"] = value(FORMAT);
        file["machine"] = value(&self.machine);
        // In quotes: TOML integers are signed, seeds are not.
        file["seed"] = value(self.seed.to_string());
        file["run_duration_s"] = value(self.run_duration_s);
        if self.off_spindle_mm != 0.0 {
            file["off_spindle_um"] = value(um_from_mm(self.off_spindle_mm));
        }
        let mut location = location_table(&self.location);
        for NamedError { joint, direction, amount } in &self.named {
            let (unit, edge) = edge(*direction, *amount);
            location[&format!("E{direction}0{joint}_{unit}")] = value(edge);
        }
        file["location"] = Item::Table(location);
        file["noise"] = Item::Table(noise_table(&self.noise));
        // Other instruments are mounted again by every cycle.
        file["setup"] = Item::ArrayOfTables(self.setups.iter().filter_map(setup_table).collect());
        if !self.hidden.is_empty() {
            file["hidden"] =
                Item::ArrayOfTables(self.hidden.iter().map(hidden_table).collect::<ArrayOfTables>());
        }
        file.to_string()
    }

    /// Reads a truth file; `file` is shown in problems.
    ///
    /// # Errors
    /// Every problem of the file, with line, what was found and what is allowed.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(file, text)?;
        let truth = read(&document.root());
        document.finish(truth)
    }
}

fn location_table(location: &JointErrors) -> toml_edit::Table {
    let mut table = toml_edit::Table::new();
    for error in every_location_error() {
        let amount = error.of(location);
        if amount != 0.0 {
            table[&location_key(error)] = value(edge(error.direction, amount).1);
        }
    }
    table
}

/// Unit and number of a location error in files.
fn edge(direction: Joint, amount: f64) -> (&'static str, f64) {
    if direction.is_rotary() { ("urad", urad_from_rad(amount)) } else { ("um", um_from_mm(amount)) }
}

fn noise_table(noise: &Noise) -> toml_edit::Table {
    let mut table = toml_edit::Table::new();
    for (key, amount) in [
        ("white_um", um_from_mm(noise.white_mm)),
        ("pass_offset_um", um_from_mm(noise.pass_offset_mm)),
        ("drift_um", um_from_mm(noise.drift_mm)),
        ("drift_time_s", noise.drift_time_s),
        ("repeatability_urad", urad_from_rad(noise.repeatability_rad)),
        ("natural_motion_um", um_from_mm(noise.natural_motion_mm)),
        ("outlier_share", noise.outlier_share),
        ("outlier_um", um_from_mm(noise.outlier_mm)),
    ] {
        table[key] = value(amount);
    }
    table
}

fn setup_table(placed: &PlacedSetup) -> Option<toml_edit::Table> {
    let mut table = toml_edit::Table::new();
    table["name"] = value(&placed.setup.name);
    let Instrument { kind, length_mm, .. } = placed.setup.instrument;
    table["instrument"] = value(kind.name());
    match kind {
        InstrumentKind::RTest => {}
        InstrumentKind::BallBar => table["length_mm"] = value(length_mm),
        _ => return None,
    }
    table["nest"] = value(match placed.setup.nest {
        NestOn::Table => "table",
        NestOn::Spindle => "spindle",
    });
    table["ball_in_table_mm"] = value(placed.setup.ball_in_table_mm.iter().copied().collect::<Array>());
    table["setting_um"] = value(placed.setting_mm.iter().map(|&mm| um_from_mm(mm)).collect::<Array>());
    Some(table)
}

fn hidden_table(hidden: &Hidden) -> toml_edit::Table {
    let mut shape = toml_edit::Table::new();
    for (name, amount) in hidden.kind.shape.iter().zip(&hidden.shape) {
        shape[name] = value(*amount);
    }
    let mut table = toml_edit::Table::new();
    table["id"] = value(hidden.id());
    table["amplitude"] = value(hidden.amplitude);
    table["shape"] = Item::Table(shape);
    table
}

fn read(root: &Table<'_>) -> Option<Truth> {
    let format = root.format(FORMAT);
    let machine = root.string("machine");
    let seed = root.string("seed").and_then(|text| {
        let seed = text.parse().ok();
        if seed.is_none() {
            root.problem("seed", format!("= \"{text}\""), "a whole number from 0 to 2^64 − 1 in quotes", "");
        }
        seed
    });
    let run_duration_s = root.number("run_duration_s", DURATION_S);
    let off_spindle_um = root.optional_number("off_spindle_um", SIZE);
    let location = root.table("location").map(|table| read_location(&table));
    let noise = root.table("noise").and_then(|table| read_noise(&table));
    let setups: Vec<_> = root.tables("setup").iter().map(read_setup).collect();
    if setups.is_empty() {
        root.problem("setup", "is missing", "one [[setup]] or more", "");
    }
    let hidden: Vec<_> = root.tables("hidden").iter().map(read_hidden).collect();
    root.no_other_keys();
    format?;
    let (location, named) = location?;
    Some(Truth {
        machine: machine?,
        seed: seed?,
        run_duration_s: run_duration_s?,
        location,
        named,
        off_spindle_mm: mm_from_um(off_spindle_um.unwrap_or_default()),
        setups: setups.into_iter().collect::<Option<_>>()?,
        noise: noise?,
        hidden: hidden.into_iter().collect::<Option<_>>()?,
    })
}

fn read_location(table: &Table<'_>) -> (JointErrors, Vec<NamedError>) {
    let mut location = JointErrors::default();
    let present = table.keys();
    for error in every_location_error() {
        let key = location_key(error);
        if !present.contains(&key) {
            continue;
        }
        let Some(edge) = table.optional_number(&key, -1e6..=1e6) else { continue };
        location[error.axis] += error.twist() * inside(error.direction, edge);
    }
    let letter = |joint: &str| Joint::ALL.iter().any(|letter| letter.as_str() == joint);
    let mut named = Vec::new();
    for key in &present {
        let Some((joint, direction)) = NamedError::of_key(key).filter(|(joint, _)| !letter(joint)) else {
            continue;
        };
        if let Some(edge) = table.optional_number(key, -1e6..=1e6) {
            named.push(NamedError { joint, direction, amount: inside(direction, edge) });
        }
    }
    table.no_other_keys();
    (location, named)
}

fn inside(direction: Joint, edge: f64) -> f64 {
    if direction.is_rotary() { rad_from_urad(edge) } else { mm_from_um(edge) }
}

fn read_noise(table: &Table<'_>) -> Option<Noise> {
    let um = |key| table.number(key, SIZE).map(mm_from_um);
    let noise =
        [um("white_um"), um("pass_offset_um"), um("drift_um"), um("natural_motion_um"), um("outlier_um")];
    let drift_time_s = table.number("drift_time_s", DURATION_S);
    let repeatability_rad = table.number("repeatability_urad", SIZE).map(rad_from_urad);
    let outlier_share = table.number("outlier_share", 0.0..=1.0);
    table.no_other_keys();
    let [white_mm, pass_offset_mm, drift_mm, natural_motion_mm, outlier_mm] = noise;
    Some(Noise {
        white_mm: white_mm?,
        pass_offset_mm: pass_offset_mm?,
        drift_mm: drift_mm?,
        drift_time_s: drift_time_s?,
        repeatability_rad: repeatability_rad?,
        natural_motion_mm: natural_motion_mm?,
        outlier_share: outlier_share?,
        outlier_mm: outlier_mm?,
    })
}

fn read_setup(table: &Table<'_>) -> Option<PlacedSetup> {
    let name = table.string("name");
    let instrument = match table.one_of("instrument", &["r-test", "ball-bar"]).as_deref() {
        Some("ball-bar") => table.number("length_mm", 1.0..=10_000.0).map(Instrument::ball_bar),
        Some(_) => Some(Instrument::R_TEST),
        None => None,
    };
    let nest = table.one_of("nest", &["table", "spindle"]);
    let ball = table.vector3("ball_in_table_mm");
    let setting = table.vector3("setting_um");
    table.no_other_keys();
    let nest = if nest? == "spindle" { NestOn::Spindle } else { NestOn::Table };
    let setup = SimSetup::new(name?, nest, Point3::from(ball?), instrument?);
    Some(PlacedSetup::new(&setup, setting?.map(mm_from_um)))
}

fn read_hidden(table: &Table<'_>) -> Option<Hidden> {
    let id = table.string("id");
    let found = id.and_then(|id| match hidden::find(&id) {
        Ok(found) => Some(found),
        Err(_) => {
            table.problem("id", format!("= \"{id}\""), names::allowed(&id, hidden::ids()), "");
            None
        }
    });
    let amplitude = table.number("amplitude", ANY);
    let numbers = table.table("shape");
    let (kind, place) = found?;
    let numbers = numbers?;
    let shape: Vec<_> = kind.shape.iter().map(|name| numbers.number(name, ANY)).collect();
    numbers.no_other_keys();
    table.no_other_keys();
    Some(Hidden { kind, place, amplitude: amplitude?, shape: shape.into_iter().collect::<Option<_>>()? })
}

fn every_location_error() -> impl Iterator<Item = LocationError> {
    let of = |axis| Joint::ALL.into_iter().map(move |direction| LocationError { axis, direction });
    Joint::ALL.into_iter().flat_map(of)
}

fn location_key(error: LocationError) -> String {
    format!("{}_{}", error.name(), if error.direction.is_rotary() { "urad" } else { "um" })
}
