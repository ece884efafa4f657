//! An identification for machines (JSON of docs/design/contracts.md §6) and for people (a table).

use crate::fit::identification::{Identification, NoisePart};
use crate::solve::direction::Status;
use serde_json::{Value, json};
use std::fmt;
use trunnion_core::convert::um_from_mm;

impl Identification {
    /// `trunnion-identification/1`.
    pub fn to_json(&self) -> Value {
        let parameters: Vec<Value> = self
            .parameters
            .iter()
            .map(|p| {
                json!({
                    "name": p.name,
                    "effect": p.effect,
                    "value": p.screen_value(),
                    "unit": p.unit.symbol,
                    "u": p.screen_u(),
                    "observable": p.observable(),
                    "note": p.note,
                })
            })
            .collect();
        let unobservable: Vec<Value> = self
            .unobservable
            .iter()
            .map(|d| {
                let term =
                    |(name, coefficient): &(String, f64)| json!({"name": name, "coefficient": coefficient});
                let terms: Vec<Value> = d.terms.iter().map(term).collect();
                json!({"direction": d.direction, "why": d.why, "terms": terms})
            })
            .collect();
        let shapes: Vec<Value> = self
            .effects
            .iter()
            .filter(|effect| !effect.shape.is_empty())
            .map(|effect| json!({"effect": effect.id, "names": effect.shape_names, "values": effect.shape}))
            .collect();
        let outlier_points: Vec<Value> = self
            .outliers
            .iter()
            .map(|o| {
                json!({
                    "point": o.point,
                    "run": o.run,
                    "setup": o.setup,
                    "pose": o.pose,
                    "residual_um": um_from_mm(o.residual_mm),
                })
            })
            .collect();
        json!({
            "format": "trunnion-identification/1",
            "machine": self.machine,
            "runs": self.runs,
            "effects": self.effects.iter().map(|effect| &effect.id).collect::<Vec<_>>(),
            "shapes": shapes,
            "points": self.points,
            "outliers": self.outliers.len(),
            "outlier_points": outlier_points,
            "rms_um": um_from_mm(self.rms_mm),
            "noise_um": self.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
            "noise_origin": self.repeatability.map(|_| "repeats"),
            "repeats": self.repeatability.map(|noise| noise.repeats),
            "noise_degrees_of_freedom": self.repeatability.map(|noise| noise.degrees_of_freedom),
            "u_origin": if self.noise_parts.is_empty() { "clusters" } else { "noise-parts" },
            "noise_parts": self.noise_parts.iter().map(|part| json!({
                "part": part.name,
                "um": um_from_mm(part.sigma_mm),
            })).collect::<Vec<_>>(),
            "noise_by_run": self.noise_by_run.iter().map(|g| json!({
                "run": g.run,
                "instrument": g.instrument.name(),
                "readings": g.readings,
                "rms_um": um_from_mm(g.rms_mm),
                "floor_um": um_from_mm(g.floor_mm),
                "samples_um": um_from_mm(g.samples_mm),
            })).collect::<Vec<_>>(),
            "holdout_rms_um": self.holdout_rms_mm().map(um_from_mm),
            "holdout_unit": self.holdout.map(|holdout| holdout.left_out.name()),
            "rank": self.rank,
            "condition": self.condition,
            "degrees_of_freedom": self.degrees_of_freedom,
            "parameters": parameters,
            "unobservable": unobservable,
            "seen_together": self.seen_together.iter().map(|c| json!({
                "combination": c.text,
                "value": c.value,
                "unit": c.unit,
                "u": c.u,
            })).collect::<Vec<_>>(),
        })
    }
}

impl fmt::Display for Identification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Machine {}, {} points of {}", self.machine, self.points, self.runs.join(", "))?;
        let width = self.parameters.iter().map(|p| p.name.chars().count()).max().unwrap_or(0).max(9);
        writeln!(f, "{:width$}  {:>12}  {:>10}  unit", "parameter", "value", "u")?;
        let mut effect = "";
        for p in &self.parameters {
            if p.effect != effect {
                effect = &p.effect;
                let shape = self.effects.iter().find(|e| e.id == effect).map_or(String::new(), |e| {
                    let values = e.shape_names.iter().zip(&e.shape);
                    values.map(|(name, value)| format!("  {name} = {value:.4}")).collect()
                });
                writeln!(f, "{effect}{shape}")?;
            }
            let number =
                |x: Option<f64>, decimals: usize| x.map_or_else(|| "-".into(), |x| format!("{x:.decimals$}"));
            let (value, u) = (number(p.screen_value(), 3), number(p.screen_u(), 3));
            let unit = screen_unit(p.unit.symbol);
            writeln!(f, "{:width$}  {value:>12}  {u:>10}  {unit:6}  {}", p.name, p.note)?;
        }
        writeln!(f, "residual rms  {:.3} µm", um_from_mm(self.rms_mm))?;
        match self.repeatability {
            Some(noise) => {
                let (um, repeats) = (um_from_mm(noise.sigma_mm), noise.repeats);
                writeln!(f, "repeatability {um:.3} µm (from {repeats} repeats)")?;
            }
            None => writeln!(f, "repeatability not known: no pose was measured twice")?,
        }
        match &self.noise_parts[..] {
            [] => {
                writeln!(f, "u             from clusters of the residual: pass × position of the slow axis")?
            }
            parts => {
                let sigma = |part: &NoisePart| format!("{} {:.3}", part.name, um_from_mm(part.sigma_mm));
                let parts: Vec<String> = parts.iter().map(sigma).collect();
                writeln!(f, "u             from noise of these parts, µm: {}", parts.join(", "))?;
            }
        }
        for g in self.noise_by_run.iter().filter(|_| self.noise_by_run.len() > 1) {
            let (rms, floor) = (um_from_mm(g.rms_mm), um_from_mm(g.floor_mm));
            let instrument = g.instrument.name();
            writeln!(
                f,
                "  {}, {instrument}: rms {rms:.3} µm, floor {floor:.3} µm, {} readings",
                g.run, g.readings
            )?;
        }
        if let Some(holdout) = self.holdout {
            let parts = holdout.left_out.plural();
            let rms = um_from_mm(holdout.rms_mm);
            writeln!(f, "held out      {rms:.3} µm ({} {parts} left out in turn)", holdout.parts)?;
        }
        let numbers = self.parameters.iter().filter(|p| p.status == Status::Identified).count();
        writeln!(
            f,
            "rank {}, condition {:.0}, {numbers} numbers, {} degrees of freedom",
            self.rank, self.condition, self.degrees_of_freedom
        )?;
        for o in &self.outliers {
            let size = um_from_mm(o.residual_mm);
            writeln!(
                f,
                "excluded: point {} of {}, setup {}, {}: {size:.1} µm",
                o.point, o.run, o.setup, o.pose
            )?;
        }
        for c in &self.seen_together {
            writeln!(f, "together: {} = {:.3} ± {:.3} {}", c.text, c.value, c.u, screen_unit(c.unit))?;
        }
        if !self.unobservable.is_empty() {
            writeln!(f, "cannot be seen:")?;
        }
        for d in &self.unobservable {
            writeln!(f, "  {}: {}", d.direction, d.why)?;
        }
        Ok(())
    }
}

fn screen_unit(symbol: &str) -> String {
    symbol.replace("um", "µm").replace("urad", "µrad")
}
