//! Writing a cycle file that [`Cycle::parse`] reads back the same.

use super::definition::{Bar, BarFrame, GridAxis, Motion, Rounds, Settle};
use super::{Cycle, Line, Path};
use crate::RunKind;
use nalgebra::{Point3, Vector3};
use std::fmt::Write;
use trunnion_core::setup::{NestSide, Setup};
use trunnion_core::{AxisValues, Joint, Target, convert};

/// Angles are written to this many decimals of a degree: 2·10⁻¹² rad.
const DECIMALS: i32 = 10;

impl Cycle {
    /// The cycle file.
    pub fn to_text(&self) -> String {
        let kind = match self.run_kind() {
            RunKind::Static => "static",
            RunKind::OnTheFly => "on-the-fly",
        };
        let (Motion::Static { passes, .. }
        | Motion::Line { passes, .. }
        | Motion::Path { passes, .. }
        | Motion::OnTheFly { passes, .. }) = &self.motion;
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
            Motion::Line { line, settle, .. } => text += &(line_text(line) + &settle_text(settle)),
            Motion::Path { path, from_to_rad, feeds_mm_per_s, .. } => {
                text += &path_text(path, *from_to_rad, feeds_mm_per_s);
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
    if setup.ball_in_tool_mm != Point3::origin() {
        text += &format!("ball_in_tool_mm = {}\n", vector(&setup.ball_in_tool_mm.coords));
    }
    if let Some(direction) = setup.direction {
        text += &format!("direction = {}\n", vector(&direction));
    }
    if let Some([first, second]) = setup.arms_mm {
        text += &format!("arms_mm = [{first}, {second}]\n");
    }
    if setup.calibrated {
        text += "calibrated = true\n";
    }
    if let Some(artefact) = &setup.artefact {
        let turned_deg = artefact.turned_rad.map(deg);
        text += &format!("[setup.artefact]\nname = {}\n", quoted(&artefact.name));
        text += &format!("turned_deg = {}\n", vector(&turned_deg));
        text.extend(artefact.targets.iter().map(target_text));
    }
    text
}

fn target_text(target: &Target) -> String {
    let (name, at) = (quoted(&target.name), vector(&target.at_mm));
    let normal = target.normal.map_or_else(String::new, |normal| format!("normal = {}\n", vector(&normal)));
    format!("[[setup.artefact.target]]\nname = {name}\nat_mm = {at}\n{normal}")
}

fn vector(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

fn line_text(line: &Line) -> String {
    let Line { length_mm, steps, in_turn } = line;
    format!("\n[line]\nlength_mm = {length_mm}\nsteps = {steps}\nin_turn = {in_turn}\n")
}

fn path_text(path: &Path, (from, to): (f64, f64), feeds_mm_per_s: &[f64]) -> String {
    let shape = match path {
        Path::Circle { plane: [first, second], radius_mm } => {
            let radius = radius_mm.map_or_else(String::new, |radius_mm| format!("radius_mm = {radius_mm}\n"));
            format!("\n[circle]\nplane = \"{first}{second}\"\n{radius}")
        }
        Path::Cone { half_angle_rad, tilt_rad } => {
            let (half_angle, tilt) = (deg(*half_angle_rad), deg(*tilt_rad));
            format!("\n[cone]\nhalf_angle_deg = {half_angle}\ntilt_deg = {tilt}\n")
        }
    };
    let feeds: Vec<f64> = feeds_mm_per_s.iter().map(|feed| round(feed * 60.0)).collect();
    let (from, to, feeds) = (deg(from), deg(to), list(&feeds));
    format!("{shape}from_deg = {from}\nto_deg = {to}\nfeeds_mm_per_min = [{feeds}]\n")
}

fn grid_text(axis: &GridAxis) -> String {
    let rotary = axis.letter.is_rotary();
    let unit = if rotary { "deg" } else { "mm" };
    let stations: Vec<f64> =
        axis.stations.iter().map(|&at| if rotary { deg(at) } else { round(at) }).collect();
    let mut text = format!("\n[[grid]]\naxis = \"{}\"\n", axis.letter);
    match even_step(&stations) {
        Some(step) => {
            let (from, to) = (stations[0], stations[stations.len() - 1]);
            text += &format!("from_{unit} = {from}\nto_{unit} = {to}\nstep_{unit} = {step}\n");
        }
        None => text += &format!("stations_{unit} = [{}]\n", list(&stations)),
    }
    text
}

/// The step of stations that from, to and step give exactly.
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
    axis: Joint,
    (from, to): (f64, f64),
    feeds_rad_per_s: &[f64],
    others: &AxisValues<(f64, f64)>,
) -> String {
    let feeds: Vec<f64> = feeds_rad_per_s.iter().map(|feed| deg(feed * 60.0)).collect();
    let mut text = format!(
        "\n[sweep]\naxis = \"{axis}\"\nfrom_deg = {}\nto_deg = {}\nfeeds_deg_per_min = [{}]\n",
        deg(from),
        deg(to),
        list(&feeds)
    );
    for letter in Joint::ROTARY.into_iter().filter(|&letter| others[letter] != (0.0, 0.0)) {
        let (first, last) = (deg(others[letter].0), deg(others[letter].1));
        let angles = if first == last { format!("{first}") } else { format!("[{first}, {last}]") };
        writeln!(text, "{}_deg = {angles}", letter.lower()).expect("a string takes all");
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
