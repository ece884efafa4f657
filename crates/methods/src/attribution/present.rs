//! An attribution as findings: text, page and JSON are those of every method.

use super::{Attribution, Deviation, Ideal, LeftOut, Share, largest};
use crate::Findings;
use crate::findings::{AxisName, Cell, Chart, Column, Curve, FoundTable, FoundValue, Plot, ValueKind};
use crate::recipes::Convention;
use nalgebra::Vector3;
use trunnion_core::Joint;
use trunnion_core::number::signed;
use trunnion_effects::Unit;

/// Axes drawn next to the sum.
const DRAWN: usize = 3;
/// Bins of a chart; two points of each are drawn, its lowest and highest.
const BINS: usize = 300;

impl Attribution {
    /// The answer of a recording before anything is in it: also of one that cannot be judged.
    pub fn nothing_found(run: &str, machine: &str) -> Findings {
        let method = ["attribute", "S3 §3.1"];
        Findings::nothing_yet(method, Convention::RightHanded, machine.into(), vec![run.into()])
    }

    /// Values, table, charts and notes.
    pub fn to_findings(&self) -> Findings {
        Findings {
            values: std::iter::once(self.whole())
                .chain(self.shares.iter().map(|share| self.value(share)))
                .collect(),
            tables: vec![self.table()],
            charts: self.charts(),
            notes: self.notes(),
            ..Self::nothing_found(&self.run, &self.machine)
        }
    }

    /// What all axes made together: also where none has a share.
    fn whole(&self) -> FoundValue {
        FoundValue::new("peak by all axes", self.together.peak_mm(), Unit::UM, None)
            .kind(ValueKind::Summary)
            .note("largest deviation of the tool point by what the encoders read")
    }

    /// Largest deviation of the tool point that the axis made.
    fn value(&self, share: &Share) -> FoundValue {
        let places = &share.deviation.place_mm;
        let worst = (0..places.len()).max_by(|&a, &b| places[a].norm().total_cmp(&places[b].norm()));
        let note = worst.map_or(String::new(), |i| {
            let [x, y, z] = [0, 1, 2].map(|k| signed_um(places[i][k]));
            let own = share.own[i] * own_unit(share).per_inside;
            let unit = if share.axis.is_rotary() { "µrad" } else { "µm" };
            format!(
                "at {:.3} s: X {x}, Y {y}, Z {z} µm, by {} {unit} of {}",
                self.time_s[i],
                signed(own, 2),
                share.axis
            )
        });
        FoundValue::new(format!("peak by {}", share.axis), share.deviation.peak_mm(), Unit::UM, None)
            .note(note)
    }

    fn table(&self) -> FoundTable {
        let mut columns = vec![Column::plain("axis"), Column::plain("own peak")];
        for what in ["rms", "peak"] {
            columns.extend(["X", "Y", "Z"].map(|letter| Column::of(format!("{what} {letter}"), Unit::UM)));
        }
        columns.push(Column::of("tool turns, rms", Unit::URAD));
        columns.push(Column::of("tool turns, peak", Unit::URAD));
        let row = |name: String, own: String, deviation: &Deviation| {
            let mut cells = vec![Cell::Text(name), Cell::Text(own)];
            cells.extend(deviation.rms_mm().map(Cell::Number));
            cells.extend(deviation.peaks_mm().map(Cell::Number));
            cells.extend([deviation.rms_rad(), deviation.peak_rad()].map(Cell::Number));
            cells
        };
        let of_share = |share: &Share| {
            let own = largest(share.own.iter().copied()) * own_unit(share).per_inside;
            let unit = if share.axis.is_rotary() { "µrad" } else { "µm" };
            row(share.axis.to_string(), format!("{} {unit}", signed(own, 2)), &share.deviation)
        };
        let mut rows: Vec<Vec<Cell>> = self.shares.iter().map(of_share).collect();
        rows.push(row("all together".into(), String::new(), &self.together));
        FoundTable { caption: "Share of each axis at the tool point, machine axes".into(), columns, rows }
    }

    fn charts(&self) -> Vec<Chart> {
        let mut charts = Vec::new();
        let by_time = AxisName { name: "time".into(), unit: Unit::S };
        let mut all = |group: &str, x_name: &AxisName, x: &[f64]| {
            for (k, direction) in ["X", "Y", "Z"].into_iter().enumerate() {
                let y = AxisName { name: String::new(), unit: Unit::UM };
                let of = |deviation: &Deviation| self.drawn(x, |i| deviation.place_mm[i][k]);
                charts.push(self.chart(group, &format!("Tool point in {direction}"), x_name, y, &of));
            }
            let y = AxisName { name: String::new(), unit: Unit::URAD };
            let of = |deviation: &Deviation| self.drawn(x, |i| Vector3::norm(&deviation.turn_rad[i]));
            charts.push(self.chart(group, "Orientation of the tool", x_name, y, &of));
        };
        if let Ideal::Cycle { turning, .. } = &self.ideal {
            let lead = lead(*turning);
            let x_name = AxisName { name: lead.clone(), unit: Unit::DEG };
            all(&format!("Shares over {lead}"), &x_name, &self.angle_rad);
        }
        all("Shares over time", &by_time, &self.time_s);
        let own = |share: &Share| Chart {
            group: "What each axis did itself".into(),
            title: format!("{}: measured minus ideal", share.axis),
            plot: Plot::Xy {
                x: by_time.clone(),
                y: AxisName { name: String::new(), unit: own_unit(share) },
                curves: vec![Curve::new(share.axis.to_string(), self.drawn(&self.time_s, |i| share.own[i]))],
            },
        };
        charts.extend(self.shares.iter().take(DRAWN).map(own));
        charts.retain(shows_something);
        charts
    }

    fn chart(
        &self,
        group: &str,
        title: &str,
        x: &AxisName,
        y: AxisName,
        of: &dyn Fn(&Deviation) -> Vec<(f64, f64)>,
    ) -> Chart {
        let mut curves: Vec<Curve> = self
            .shares
            .iter()
            .take(DRAWN)
            .map(|share| Curve::new(share.axis.to_string(), of(&share.deviation)))
            .collect();
        curves.push(Curve::new("all together", of(&self.together)));
        Chart { group: group.into(), title: title.into(), plot: Plot::Xy { x: x.clone(), y, curves } }
    }

    /// Lowest and highest value of each bin of a pass, so that no spike is lost; no number between passes.
    fn drawn(&self, x: &[f64], y: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        let bins = (BINS / self.passes.len()).max(20);
        let mut drawn = Vec::new();
        for pass in &self.passes {
            let mut points = Vec::new();
            let size = pass.len().div_ceil(bins).max(1);
            for start in pass.clone().step_by(size) {
                let bin = start..(start + size).min(pass.end);
                let low = bin.clone().min_by(|&a, &b| y(a).total_cmp(&y(b))).unwrap_or(start);
                let high = bin.max_by(|&a, &b| y(a).total_cmp(&y(b))).unwrap_or(start);
                points.push(low.min(high));
                if low != high {
                    points.push(low.max(high));
                }
            }
            if !drawn.is_empty() {
                drawn.push((x[pass.start], f64::NAN));
            }
            drawn.extend(points.into_iter().map(|i| (x[i], y(i))));
        }
        drawn
    }

    fn notes(&self) -> Vec<String> {
        let ideal = match &self.ideal {
            Ideal::Cycle { name, turning } => format!(
                "Ideal motion: cycle {name}, {} at the constant feed of each pass, all others where the cycle commands \
                 them then. A delay common to all axes is in no share.",
                lead(*turning)
            ),
            Ideal::Commanded { why } => format!(
                "Ideal motion: the commanded positions of the table{}. A delay common to all axes is in the share of each, and \
                 cancels in all together.{}",
                in_brackets(why),
                if self.shares.is_empty() {
                    " The encoders read exactly what was commanded, in every row: check that the table does not hold the same \
                     positions twice."
                } else {
                    ""
                }
            ),
            Ideal::Smooth { knot_s, why } => {
                let reason = in_brackets(why);
                format!(
                    "Ideal motion: a smooth path through the measured positions of each axis, knots every {knot_s} s{reason}. \
                     What lasts longer than that passes for the path."
                )
            }
        };
        vec![
            ideal,
            self.judged(),
            "A share is what disappears at the tool point, against the table, when the measured motion of one axis is replaced by \
             its ideal motion."
                .into(),
            "Encoders see what their own axis does. Geometric errors, backlash behind an encoder and bending are in no share."
                .into(),
            format!("The shares add up to all together within {:.3} µm.", self.beyond_sum_mm * 1e3),
        ]
    }

    /// How many positions the figures hold, and what was left out of them.
    fn judged(&self) -> String {
        let LeftOut { run_in_and_out, elsewhere } = self.left_out;
        let judged = self.time_s.len();
        let of_all = format!("{judged} of {} axis positions are judged", judged + run_in_and_out + elsewhere);
        match (&self.ideal, run_in_and_out + elsewhere) {
            (_, 0) => format!("{of_all}."),
            (Ideal::Cycle { .. }, _) => format!(
                "{of_all}: those at the constant feed of a pass. Left out: {run_in_and_out} of run-in and run-out, {elsewhere} \
                 outside the passes."
            ),
            (Ideal::Commanded { .. } | Ideal::Smooth { .. }, _) => {
                format!("{of_all}. Left out: {elsewhere} in stretches too short for a smooth path.")
            }
        }
    }
}

/// Why not the cycle; nothing where there was none.
fn in_brackets(why: &str) -> String {
    if why.is_empty() { String::new() } else { format!(" ({why})") }
}

/// What leads the motion of a cycle.
fn lead(turning: Option<Joint>) -> String {
    turning.map_or_else(|| "angle on the curve".into(), |axis| axis.to_string())
}

/// False for a chart in which everything is zero.
fn shows_something(chart: &Chart) -> bool {
    match &chart.plot {
        Plot::Xy { curves, .. } => {
            curves.iter().any(|curve| curve.points.iter().any(|point| point.1.abs() > 0.0))
        }
        Plot::Polar { .. } | Plot::Path { .. } | Plot::Bars { .. } | Plot::PlaneMap { .. } => true,
    }
}

fn own_unit(share: &Share) -> Unit {
    if share.axis.is_rotary() { Unit::URAD } else { Unit::UM }
}

fn signed_um(mm: f64) -> String {
    signed(mm * 1e3, 1)
}
