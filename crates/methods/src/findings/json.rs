//! Findings for machines: `trunnion-findings/1`, numbers in the units they name.

use super::{AxisName, Cell, Chart, Curve, Findings, FoundTable, Plot};
use serde_json::{Value, json};
use trunnion_effects::Unit;

impl Findings {
    /// `trunnion-findings/1`: method, source, convention, machine, runs, values, tables, charts with all their points, notes.
    pub fn to_json(&self) -> Value {
        let values = self.values.iter().map(|v| {
            json!({
                "name": v.name,
                "value": v.value * v.unit.per_inside,
                "unit": v.unit.symbol,
                "u": v.u.map(|u| u * v.unit.per_inside),
                "note": v.note,
            })
        });
        json!({
            "format": "trunnion-findings/1",
            "method": self.method,
            "source": self.source,
            "convention": self.convention.name(),
            "machine": self.machine,
            "runs": self.runs,
            "values": values.collect::<Vec<_>>(),
            "tables": self.tables.iter().map(table).collect::<Vec<_>>(),
            "charts": self.charts.iter().map(chart).collect::<Vec<_>>(),
            "notes": self.notes,
        })
    }
}

fn table(table: &FoundTable) -> Value {
    let columns =
        table.columns.iter().map(|c| json!({"name": c.name, "unit": c.unit.map(|unit| unit.symbol)}));
    let row = |row: &Vec<Cell>| -> Vec<Value> {
        row.iter()
            .zip(&table.columns)
            .map(|(cell, column)| match cell {
                Cell::Text(text) => json!(text),
                Cell::Number(number) => json!(number * column.unit.map_or(1.0, |unit| unit.per_inside)),
                Cell::Missing => Value::Null,
            })
            .collect()
    };
    json!({
        "caption": table.caption,
        "columns": columns.collect::<Vec<_>>(),
        "rows": table.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

fn chart(chart: &Chart) -> Value {
    let mut value = match &chart.plot {
        Plot::Polar { unit, curves } => {
            json!({"kind": "polar", "x_unit": "deg", "y_unit": unit.symbol, "curves": all(curves, Unit::DEG, *unit)})
        }
        Plot::Xy { x, y, curves } => json!({
            "kind": "xy",
            "x": axis(x),
            "y": axis(y),
            "curves": all(curves, x.unit, y.unit),
        }),
        Plot::Path { unit, names, curves } => {
            json!({"kind": "path", "names": names, "unit": unit.symbol, "curves": all(curves, *unit, *unit)})
        }
        Plot::PlaneMap { names, magnification, places } => {
            let off_um = |off: [f64; 2]| off.map(|mm| mm * Unit::UM.per_inside);
            let places = places.iter().map(|place| {
                json!({
                    "commanded_mm": place.commanded_mm,
                    "measured_off_um": off_um(place.measured_off_mm),
                    "simulated_off_um": place.simulated_off_mm.map(off_um),
                })
            });
            let places: Vec<Value> = places.collect();
            json!({"kind": "plane-map", "names": names, "magnification": magnification, "places": places})
        }
    };
    value["group"] = json!(chart.group);
    value["title"] = json!(chart.title);
    value
}

fn axis(axis: &AxisName) -> Value {
    json!({"name": axis.name, "unit": axis.unit.symbol})
}

fn all(curves: &[Curve], x: Unit, y: Unit) -> Vec<Value> {
    let points = |curve: &Curve| -> Vec<[f64; 2]> {
        curve.points.iter().map(|(a, b)| [a * x.per_inside, b * y.per_inside]).collect()
    };
    curves.iter().map(|curve| json!({"name": curve.name, "points": points(curve)})).collect()
}
