//! What a named method of the literature, or an attribution, found: values, tables and charts.

use crate::number::finite;
use crate::plausibility::Plausibility;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects::Unit;
use trunnion_effects::sources::{sources, with_authors};
use trunnion_methods::findings as found;

/// `trunnion-findings/1`: what a method found; every number in the unit that it names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Findings {
    /// Format and version.
    pub format: FindingsFormat,
    /// Name of the method, e.g. `two-height`.
    pub method: String,
    /// Where the recipe comes from.
    pub source: String,
    /// Signs of the values: `right-handed` or `source`.
    pub convention: String,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs used.
    pub runs: Vec<String>,
    /// Why these runs cannot be judged; empty for good ones.
    #[serde(default)]
    pub plausibility: Vec<Plausibility>,
    /// Readings that count in no value, because they lie far from the rest of a fit; 0 where a method excludes none.
    #[serde(default)]
    pub excluded: usize,
    /// What was found, most important first.
    pub values: Vec<FoundValue>,
    /// Further numbers.
    pub tables: Vec<Table>,
    /// Charts with all their points; neighbours of one group share a heading.
    pub charts: Vec<Chart>,
    /// Assumptions, and what these runs could not show.
    pub notes: Vec<String>,
    /// What the method says to do, in order; empty where it knows no more than its values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub to_do: Vec<String>,
}

/// Format and version of findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FindingsFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-findings/1")]
    V1,
}

/// One value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FoundValue {
    /// Name by ISO 230-1 where it has one, e.g. `EB0C`.
    pub name: String,
    /// Value in `unit`.
    pub value: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty in `unit`; null when these runs do not show it.
    pub u: Option<f64>,
    /// A remark; may be empty.
    pub note: String,
    /// What it is about.
    #[serde(default)]
    pub kind: ValueKind,
}

/// What a value is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ValueKind {
    /// An error of the machine, or a number that goes with it.
    #[default]
    Error,
    /// What mounting left.
    Setting,
    /// What the whole measurement comes to, as its standard names it.
    Summary,
    /// The same of a part of the measurement.
    Part,
}

/// A table; every row has one cell for each column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Heads.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
}

/// Head of a column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit of its numbers; null for a column of text or plain counts.
    pub unit: Option<String>,
}

/// One cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Cell {
    /// A number in the unit of its column.
    Number(f64),
    /// Words.
    Text(String),
    /// Nothing is known.
    Missing,
}

/// A chart with its place on the page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Chart {
    /// Heading over this and its neighbours.
    pub group: String,
    /// What it shows.
    pub title: String,
    /// What is drawn.
    #[serde(flatten)]
    pub plot: Plot,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Plot {
    /// A signed value around a zero circle, over an angle.
    Polar {
        /// Unit of the angle.
        x_unit: String,
        /// Unit of the value.
        y_unit: String,
        /// Angle and value.
        curves: Vec<Curve>,
    },
    /// A value over another.
    Xy {
        /// What runs to the right.
        x: AxisName,
        /// What runs up.
        y: AxisName,
        /// Lines or sets of points.
        curves: Vec<Curve>,
    },
    /// Paths in a plane with equal scales in both directions.
    Path {
        /// Names of the directions to the right and up.
        names: [String; 2],
        /// Unit of both directions.
        unit: String,
        /// Paths.
        curves: Vec<Curve>,
    },
    /// Amounts by name, largest first.
    Bars {
        /// Unit of the amounts.
        unit: String,
        /// The bars.
        bars: Vec<NamedAmount>,
    },
    /// Commanded, measured and simulated places in a plane, deviations magnified.
    PlaneMap {
        /// Names of the directions to the right and up.
        names: [String; 2],
        /// How much larger deviations are drawn than they are.
        magnification: f64,
        /// The places.
        places: Vec<MapPlace>,
    },
}

/// What an axis of a chart shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisName {
    /// Name without unit.
    pub name: String,
    /// Unit.
    pub unit: String,
}

/// A line or a set of points of a chart.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Curve {
    /// Name in the key.
    pub name: String,
    /// Points in the order of the line, those that have both numbers.
    pub points: Vec<[f64; 2]>,
}

/// One bar.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NamedAmount {
    /// What it is of.
    pub name: String,
    /// How much.
    pub amount: f64,
    /// Said next to the bar; may be empty.
    pub remark: String,
}

/// One place of a map in a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapPlace {
    /// Where it was commanded, mm.
    pub commanded_mm: [f64; 2],
    /// Measured deviation, µm.
    pub measured_off_um: [f64; 2],
    /// Deviation by the errors that were found, µm; null on a map of measurements alone.
    pub simulated_off_um: Option<[f64; 2]>,
}

impl Findings {
    /// The value of this name.
    pub fn value(&self, name: &str) -> Option<&FoundValue> {
        self.values.iter().find(|value| value.name == name)
    }
}

impl From<&found::Findings> for Findings {
    fn from(findings: &found::Findings) -> Self {
        let value = |v: &found::FoundValue| FoundValue {
            name: v.name.clone(),
            value: finite(v.value * v.unit.per_inside),
            unit: v.unit.symbol.into(),
            u: v.u.map(|u| u * v.unit.per_inside).and_then(finite),
            note: with_authors(&v.note),
            kind: match v.kind {
                found::ValueKind::Error => ValueKind::Error,
                found::ValueKind::Setting => ValueKind::Setting,
                found::ValueKind::Summary => ValueKind::Summary,
                found::ValueKind::Part => ValueKind::Part,
            },
        };
        Self {
            format: FindingsFormat::V1,
            method: findings.method.into(),
            source: sources(findings.source),
            convention: findings.convention.name().into(),
            machine: findings.machine.clone(),
            runs: findings.runs.clone(),
            plausibility: Vec::new(),
            excluded: findings.excluded,
            values: findings.values.iter().map(value).collect(),
            tables: findings.tables.iter().map(table).collect(),
            charts: findings.charts.iter().map(chart).collect(),
            notes: findings.notes.iter().map(|note| with_authors(note)).collect(),
            to_do: findings.to_do.iter().map(|text| with_authors(text)).collect(),
        }
    }
}

fn table(table: &found::FoundTable) -> Table {
    let column =
        |c: &found::Column| Column { name: c.name.clone(), unit: c.unit.map(|unit| unit.symbol.into()) };
    let cell = |(cell, column): (&found::Cell, &found::Column)| match cell {
        found::Cell::Text(text) => Cell::Text(with_authors(text)),
        found::Cell::Number(number) => finite(number * column.unit.map_or(1.0, |unit| unit.per_inside))
            .map_or(Cell::Missing, Cell::Number),
        found::Cell::Missing => Cell::Missing,
    };
    Table {
        caption: with_authors(&table.caption),
        columns: table.columns.iter().map(column).collect(),
        rows: table.rows.iter().map(|row| row.iter().zip(&table.columns).map(cell).collect()).collect(),
    }
}

fn chart(chart: &found::Chart) -> Chart {
    let plot = match &chart.plot {
        found::Plot::Polar { unit, curves: all } => Plot::Polar {
            x_unit: Unit::DEG.symbol.into(),
            y_unit: unit.symbol.into(),
            curves: curves(all, Unit::DEG, *unit),
        },
        found::Plot::Xy { x, y, curves: all } => {
            Plot::Xy { x: axis(x), y: axis(y), curves: curves(all, x.unit, y.unit) }
        }
        found::Plot::Path { unit, names, curves: all } => {
            Plot::Path { names: names.clone(), unit: unit.symbol.into(), curves: curves(all, *unit, *unit) }
        }
        found::Plot::Bars { unit, bars } => {
            let bar = |bar: &found::NamedAmount| NamedAmount {
                name: bar.name.clone(),
                amount: bar.amount * unit.per_inside,
                remark: with_authors(&bar.remark),
            };
            let drawn = bars.iter().filter(|bar| bar.amount.is_finite());
            Plot::Bars { unit: unit.symbol.into(), bars: drawn.map(bar).collect() }
        }
        found::Plot::PlaneMap { names, magnification, places } => Plot::PlaneMap {
            names: names.clone(),
            magnification: *magnification,
            places: places.iter().map(map_place).collect(),
        },
    };
    Chart { group: with_authors(&chart.group), title: with_authors(&chart.title), plot }
}

fn axis(axis: &found::AxisName) -> AxisName {
    AxisName { name: axis.name.clone(), unit: axis.unit.symbol.into() }
}

fn curves(curves: &[found::Curve], x: Unit, y: Unit) -> Vec<Curve> {
    let points = |curve: &found::Curve| -> Vec<[f64; 2]> {
        let scaled = curve.points.iter().map(|(a, b)| [a * x.per_inside, b * y.per_inside]);
        scaled.filter(|point| point.iter().all(|number| number.is_finite())).collect()
    };
    curves.iter().map(|curve| Curve { name: curve.name.clone(), points: points(curve) }).collect()
}

fn map_place(place: &found::MapPlace) -> MapPlace {
    let um = |off: [f64; 2]| off.map(|mm| mm * Unit::UM.per_inside);
    MapPlace {
        commanded_mm: place.commanded_mm,
        measured_off_um: um(place.measured_off_mm),
        simulated_off_um: place.simulated_off_mm.map(um),
    }
}
