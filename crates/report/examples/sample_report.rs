//! Writes the report of a points folder: `cargo run -p trunnion-report --example sample_report -- FOLDER OUT.html [ADD]`.
//!
//! FOLDER holds `points.csv` and `setup.toml` (B and C grid, table-bc); ADD is an effect to add to the base model.

use std::path::Path;
use trunnion_core::setup::parse_setup_file;
use trunnion_core::{AxisLetter, Point, Quality, State, convert};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::Model;
use trunnion_effects::model::ModelEffect;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, identify};
use trunnion_machine::shipped;
use trunnion_report::{
    CompareInput, LadderRow, compare_html, compare_text, diagnosis_text, identification_text, ladder_text,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, out, rest @ ..] = &arguments[..] else {
        return Err("usage: sample_report FOLDER OUT.html [EFFECT]".into());
    };
    let experiment = Experiment::new(&[read_run(Path::new(folder))?])?;
    let base = Model::base("table-bc");
    let mut model = base.clone();
    model.effects.extend(rest.iter().map(|id| ModelEffect { id: id.clone(), ..ModelEffect::default() }));
    let fit = identify(&experiment, &model, &Options::default())?;
    let diagnosis =
        trunnion_engine::diagnose(&experiment, &model, &trunnion_engine::diagnosis::Options::default())?;
    let mut input = CompareInput::new(&experiment, &fit, Some((&diagnosis).into()));
    input.label = "Sample report of imported points.".into();
    if let Some(effect) = rest.first() {
        let before = identify(&experiment, &base, &Options::default())?;
        input.ladder.push(LadderRow {
            effect: effect.clone(),
            fit_before_um: convert::um_from_mm(before.rms_mm),
            fit_after_um: convert::um_from_mm(fit.rms_mm),
            holdout_before_um: before.holdout_rms_mm().map(convert::um_from_mm),
            holdout_after_um: fit.holdout_rms_mm().map(convert::um_from_mm),
            ..LadderRow::default()
        });
    }
    std::fs::write(out, compare_html(&input))?;
    println!("{}", identification_text(&input.identification));
    println!("{}", compare_text(&input));
    println!("{}", input.diagnosis.as_ref().map(diagnosis_text).unwrap_or_default());
    println!("{}", ladder_text(&input.ladder, input.noise.rms_um));
    Ok(())
}

fn read_run(folder: &Path) -> Result<Run, Box<dyn std::error::Error>> {
    let setups = parse_setup_file("setup.toml", &std::fs::read_to_string(folder.join("setup.toml"))?)
        .map_err(|p| p.to_string())?;
    let text = std::fs::read_to_string(folder.join("points.csv"))?;
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().ok_or("points.csv is empty")?.split(',').collect();
    let mut points = Vec::new();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| -> Result<&str, String> {
            let column = head.iter().position(|h| *h == name).ok_or(format!("no column {name}"))?;
            cells.get(column).copied().ok_or(format!("no cell {name} in {line}"))
        };
        let number = |name: &str| -> Result<f64, Box<dyn std::error::Error>> { Ok(cell(name)?.parse()?) };
        let name = cell("setup")?;
        let setup = setups.setups.iter().position(|s| s.name == name).ok_or(format!("no setup {name}"))?;
        let mut state = State { setup, time_s: Some(number("time_s")?), ..State::default() };
        for (letter, column) in [(AxisLetter::X, "x_mm"), (AxisLetter::Y, "y_mm"), (AxisLetter::Z, "z_mm")] {
            state.position[letter] = number(column)?;
        }
        for (letter, column, direction) in
            [(AxisLetter::B, "b_deg", "direction_b"), (AxisLetter::C, "c_deg", "direction_c")]
        {
            state.position[letter] = convert::rad_from_deg(number(column)?);
            state.direction[letter] = number(direction)?;
        }
        let mut reading_mm = [0.0; 3];
        for (k, column) in ["dx_um", "dy_um", "dz_um"].into_iter().enumerate() {
            reading_mm[k] = convert::mm_from_um(number(column)?);
        }
        points.push(Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Quality::Good });
    }
    Ok(Run {
        name: folder.file_name().map_or("points".into(), |name| name.to_string_lossy().into_owned()),
        machine: shipped::machine(&setups.machine).ok_or("the machine does not ship with the program")?,
        kind: RunKind::Static,
        setups: setups.setups,
        channels: Vec::new(),
        points,
    })
}
