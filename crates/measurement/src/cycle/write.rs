//! Writing a cycle file that [`Cycle::parse`] reads back the same.

use super::{Bar, BarFrame, Cycle, GridAxis, Motion, Rounds, Settle};
use crate::setup::{NestSide, Setup};
use std::fmt::Write;
use trunnion_units::{AxisLetter, AxisValues, convert};

/// Angles are written to this many decimals of a degree: 2·10⁻¹² rad.
const DECIMALS: i32 = 10;

impl Cycle {
    /// The cycle file.
    pub fn to_text(&self) -> String {
        let kind = match self.motion {
            Motion::Static { .. } => "static",
            Motion::OnTheFly { .. } => "on-the-fly",
        };
        let (Motion::Static { passes, .. } | Motion::OnTheFly { passes, .. }) = &self.motion;
        let signs: Vec<&str> = passes.iter().map(|&p| if p < 0.0 { "\"-\"" } else { "\"+\"" }).collect();
        let mut text = format!(
            "format = \"trunnion-cycle/1\"\nname = {}\nmachine = {}\nkind = \"{kind}\"\npasses = [{}]\n",
            quoted(&self.name),
            quoted(&self.machine),
            signs.join(", "),
        );
        for setup in &self.setups {
            text += &setup_text(setup);
        }
        match &self.motion {
            Motion::Static { grid, settle, .. } => {
                text.extend(grid.iter().map(grid_text));
                text += &settle_text(settle);
            }
            Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } => {
                text += &sweep_text(*axis, *from_to_rad, feeds_rad_per_s, others);
            }
        }
        if self.rounds != Rounds::default() {
            let Rounds { count, wait_s, interleave } = self.rounds;
            text += &format!("\n[rounds]\ncount = {count}\nwait_s = {wait_s}\ninterleave = {interleave}\n");
        }
        if self.bar != Bar::default() {
            let [x, y, z] = self.bar.direction.into_inner().into();
            let frame = match self.bar.frame {
                BarFrame::Machine => "machine",
                BarFrame::Table => "table",
            };
            text += &format!("\n[bar]\ndirection = [{x}, {y}, {z}]\nframe = \"{frame}\"\n");
        }
        text
    }
}

fn setup_text(setup: &Setup) -> String {
    let [x, y, z] = setup.ball_in_table_mm.coords.into();
    let nest = match setup.nest {
        NestSide::Table => "table",
        NestSide::Spindle => "spindle",
    };
    let mut text = format!(
        "\n[[setup]]\nname = {}\ninstrument = \"{}\"\nnest = \"{nest}\"\nball_in_table_mm = [{x}, {y}, {z}]\n",
        quoted(&setup.name),
        setup.instrument.name(),
    );
    if let Some(length_mm) = setup.bar_length_mm {
        text += &format!("bar_length_mm = {length_mm}\n");
    }
    text
}

fn grid_text(axis: &GridAxis) -> String {
    let stations: Vec<f64> = axis.stations.iter().map(|&rad| deg(rad)).collect();
    let mut text = format!("\n[[grid]]\naxis = \"{}\"\n", axis.letter);
    match even_step(&stations) {
        Some(step) => {
            let (from, to) = (stations[0], stations[stations.len() - 1]);
            text += &format!("from_deg = {from}\nto_deg = {to}\nstep_deg = {step}\n");
        }
        None => text += &format!("stations_deg = [{}]\n", list(&stations)),
    }
    text
}

/// The step of stations that `from_deg`, `to_deg` and `step_deg` give exactly.
fn even_step(stations: &[f64]) -> Option<f64> {
    let (first, second) = (stations.first()?, stations.get(1)?);
    let step = round(second - first);
    let even = (0..stations.len()).all(|i| (first + step * i as f64 - stations[i]).abs() < 1e-9);
    (even && (0.001..=360.0).contains(&step)).then_some(step)
}

fn settle_text(settle: &Settle) -> String {
    format!(
        "\n[settle]\nwindow_s = {}\ndrift_um = {}\nnoise_um = {}\nstandstill_um = {}\nstandstill_deg = {}\ntimeout_s = {}\n",
        settle.window_s,
        round(convert::um_from_mm(settle.drift_mm)),
        round(convert::um_from_mm(settle.noise_mm)),
        round(convert::um_from_mm(settle.standstill_mm)),
        deg(settle.standstill_rad),
        settle.timeout_s,
    )
}

fn sweep_text(
    axis: AxisLetter,
    (from, to): (f64, f64),
    feeds_rad_per_s: &[f64],
    others: &AxisValues<f64>,
) -> String {
    let feeds: Vec<f64> = feeds_rad_per_s.iter().map(|feed| deg(feed * 60.0)).collect();
    let mut text = format!(
        "\n[sweep]\naxis = \"{axis}\"\nfrom_deg = {}\nto_deg = {}\nfeeds_deg_per_min = [{}]\n",
        deg(from),
        deg(to),
        list(&feeds)
    );
    for letter in AxisLetter::ROTARY.into_iter().filter(|&letter| others[letter] != 0.0) {
        writeln!(text, "{}_deg = {}", letter.lower(), deg(others[letter])).expect("a string takes all");
    }
    text
}

fn deg(rad: f64) -> f64 {
    round(convert::deg_from_rad(rad))
}

/// Without the last digits, which are noise of the conversion.
fn round(value: f64) -> f64 {
    let unit = 10f64.powi(DECIMALS);
    let rounded = (value * unit).round() / unit;
    if rounded == 0.0 { 0.0 } else { rounded }
}

fn list(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04X}", c as u32),
            c => out.push(c),
        }
    }
    out + "\""
}
