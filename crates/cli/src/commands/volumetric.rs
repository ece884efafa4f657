//! `trunnion volumetric`: how far tool and table are off all over a volume, by a fitted model.

use crate::load::{ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::{Path, PathBuf};
use trunnion_core::AxisLetter;
use trunnion_core::convert::{deg_from_rad, um_from_mm, urad_from_rad};
use trunnion_methods::volumetric::{Datum, Extreme, Volume, VolumetricMap};
use trunnion_report::{error_map_csv, volumetric_html, volumetric_text};

/// Volumetric accuracy and error map of a volume, by a model fitted to recordings
///
/// The largest range of the deviation of tool against table in X, Y, Z and of its orientation in A, B, C over the volume
/// (ISO 230-1), with uncertainties, and what is not in it because these recordings do not show it (docs/use/volumetric.md).
///
/// Example: trunnion volumetric tracker.mcap --model volume.toml --volume "X=-200..200,Y=-200..200" --csv map.csv
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Ranges in mm and degrees, e.g. "X=-200..200,Z=0..300,B=-90..90,C=30"; what is not named is at its measured range (linear axes) or at zero (rotary axes)
    #[arg(long, value_name = "RANGES", default_value = "", allow_hyphen_values = true)]
    volume: String,
    /// Places along each axis that moves
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u16).range(2..=101))]
    steps: u16,
    /// Point of the tool to look at, tool axes, mm: 0,0,-100 is the tip of a tool 100 mm longer than the machine file's tool point
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true, value_parser = point)]
    tool_point: Point,
    /// Coordinate system: fit removes the rigid displacement that fits the whole volume best, model keeps that of the model
    #[arg(long, value_name = "NAME", default_value = "fit", value_parser = datum)]
    datum: Datum,
    /// Page with the distorted volume
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Error map: positions, deviations, standard uncertainties
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print JSON (format trunnion-volumetric/1)
    #[arg(long)]
    json: bool,
}

/// A point in tool axes, mm.
#[derive(Clone, Copy)]
struct Point([f64; 3]);

fn point(text: &str) -> Result<Point, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.abs() <= 10_000.0)).collect();
    let point = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(Point);
    point.ok_or_else(|| "allowed: three numbers within ±10000 mm, e.g. 0,0,-100".into())
}

fn datum(text: &str) -> Result<Datum, String> {
    match text {
        "fit" => Ok(Datum::BestFit),
        "model" => Ok(Datum::Model),
        _ => Err("allowed: fit, model".into()),
    }
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let load::Loaded { runs, outcome, .. } = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    let volume = Volume::parse(&args.volume, usize::from(args.steps), &experiment.scene)?;
    let volume = Volume { point_in_tool_mm: args.tool_point.0, ..volume };
    let words = volume.words(experiment.machine());
    let fit = trunnion_engine::identify(&experiment, &model, &trunnion_engine::fit::Options::default())?;
    let map = VolumetricMap::new(&experiment, &model, &fit, volume, args.datum)?;
    let axes = experiment.machine().joints();
    if let Some(path) = &args.html {
        write(path, &volumetric_html(&map, &words, &trunnion::page::label()))?;
    }
    if let Some(path) = &args.csv {
        write(path, &error_map_csv(&map, &axes))?;
    }
    if args.json {
        terminal::print_json(&json(&map, &axes))?;
    } else {
        terminal::print(&volumetric_text(&map, &words))?;
    }
    Ok(outcome)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn json(map: &VolumetricMap, axes: &[AxisLetter]) -> serde_json::Value {
    let screen = |letter: AxisLetter, x: f64| if letter.is_rotary() { deg_from_rad(x) } else { x };
    let at = |k: usize| -> serde_json::Map<String, serde_json::Value> {
        axes.iter()
            .map(|&letter| (letter.to_string(), screen(letter, map.points[k].position[letter]).into()))
            .collect()
    };
    let extreme = |name: String, rotation: bool, e: &Extreme| {
        let scaled = if rotation { urad_from_rad } else { um_from_mm };
        let unit = if rotation { "urad" } else { "um" };
        serde_json::json!({
            "name": name, "value": scaled(e.value), "u": scaled(e.u), "unit": unit, "from": at(e.low), "to": at(e.high),
        })
    };
    let ranges = AxisLetter::ALL.into_iter().zip(&map.ranges);
    let mut values: Vec<serde_json::Value> = ranges
        .map(|(letter, range)| extreme(format!("range-{}", letter.lower()), letter.is_rotary(), range))
        .collect();
    values.push(extreme("longest-vector".into(), false, &map.longest));
    serde_json::json!({
        "format": "trunnion-volumetric/1",
        "machine": map.machine,
        "runs": map.runs,
        "volume": axes.iter().map(|&letter| {
            let (low, high) = map.volume.range[letter];
            (letter.to_string(), serde_json::json!([screen(letter, low), screen(letter, high)]))
        }).collect::<serde_json::Map<_, _>>(),
        "places": map.points.len(),
        "datum": match map.datum { Datum::BestFit => "fit", Datum::Model => "model" },
        "values": values,
        "lower_bound": map.lower_bound(),
        "unseen": map.unseen.iter().map(|u| serde_json::json!({
            "direction": u.direction,
            "moves": u.moves.iter().map(|letter| letter.as_str()).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "stood_still": map.stood_still.iter().map(|letter| letter.as_str()).collect::<Vec<_>>(),
        "left_out": map.left_out.iter().map(|l| serde_json::json!({"effect": l.effect, "why": l.why})).collect::<Vec<_>>(),
    })
}
