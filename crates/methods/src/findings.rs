//! What a named method found: values with uncertainties, tables and charts, the same type for every method.
//!
//! Inside units throughout (mm, rad, s, K); every number carries the [`Unit`] in which people read it, and whoever shows
//! it multiplies by `unit.per_inside`. Nothing here draws: `trunnion-report` does.

use crate::recipes::Convention;
use trunnion_effects::Unit;

/// The result of a named method.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Name of the method, e.g. `two-height`.
    pub method: &'static str,
    /// Where the recipe comes from.
    pub source: &'static str,
    /// Signs of the values.
    pub convention: Convention,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs used.
    pub runs: Vec<String>,
    /// Readings that count in no value, because they lie far from the rest of a fit.
    pub excluded: usize,
    /// What was found, most important first.
    pub values: Vec<FoundValue>,
    /// Further numbers.
    pub tables: Vec<FoundTable>,
    /// Pictures, in the order they are shown; neighbours of one group share a heading.
    pub charts: Vec<Chart>,
    /// What a reader must know: assumptions, what these runs could not show. One sentence or two each.
    pub notes: Vec<String>,
    /// What to do about it, in order; empty where the method knows no more than its values.
    pub to_do: Vec<String>,
}

impl Findings {
    /// Of these runs of one machine, without anything found yet.
    pub(crate) fn nothing_yet(
        [method, source]: [&'static str; 2],
        convention: Convention,
        machine: String,
        runs: Vec<String>,
    ) -> Self {
        Self {
            method,
            source,
            convention,
            machine,
            runs,
            excluded: 0,
            values: Vec::new(),
            tables: Vec::new(),
            charts: Vec::new(),
            notes: Vec::new(),
            to_do: Vec::new(),
        }
    }
}

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundValue {
    /// Name by ISO 230-1 where it has one, e.g. `EB0C`; unique within the findings.
    pub name: String,
    /// Value, inside units.
    pub value: f64,
    /// Unit on files and screens.
    pub unit: Unit,
    /// Standard uncertainty, inside units; `None` when these runs do not show it.
    pub u: Option<f64>,
    /// A remark for a person; may be empty.
    pub note: String,
    /// What it is about.
    pub kind: ValueKind,
}

/// What a value is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Debug, PartialEq)]
pub struct FoundTable {
    /// What it shows.
    pub caption: String,
    /// Heads.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
}

/// Head of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit of its numbers on files and screens; `None` for a column of text or plain counts.
    pub unit: Option<Unit>,
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, inside units of the column.
    Number(f64),
    /// Nothing is known here.
    Missing,
}

/// A picture with its place on the page.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading over this and its neighbours.
    pub group: String,
    /// What it shows.
    pub title: String,
    /// What is drawn.
    pub plot: Plot,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Plot {
    /// A signed value around a zero circle, over an angle.
    Polar {
        /// Unit of the values.
        unit: Unit,
        /// Angle (rad) and value (inside units); at most three are distinguished.
        curves: Vec<Curve>,
    },
    /// A value over another.
    Xy {
        /// What runs to the right.
        x: AxisName,
        /// What runs up.
        y: AxisName,
        /// Inside units; at most four are distinguished.
        curves: Vec<Curve>,
    },
    /// Paths in a plane with equal scales in both directions, mm.
    Path {
        /// Name and unit of both directions.
        unit: Unit,
        /// Names of the directions to the right and up.
        names: [String; 2],
        /// Places, mm; at most four are distinguished.
        curves: Vec<Curve>,
    },
    /// Amounts by name, largest first.
    Bars {
        /// Unit of the amounts.
        unit: Unit,
        /// The bars.
        bars: Vec<NamedAmount>,
    },
    /// Commanded, measured and simulated places in a plane, deviations magnified (S1 Fig. 5 and 8).
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
#[derive(Clone, Debug, PartialEq)]
pub struct AxisName {
    /// Name without unit.
    pub name: String,
    /// Unit.
    pub unit: Unit,
}

/// A line or a set of points of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the key.
    pub name: String,
    /// Points in the order of the line, inside units.
    pub points: Vec<(f64, f64)>,
}

/// One bar of [`Plot::Bars`].
#[derive(Clone, Debug, PartialEq)]
pub struct NamedAmount {
    /// What it is of.
    pub name: String,
    /// Inside units.
    pub amount: f64,
    /// Said next to the bar; may be empty.
    pub remark: String,
}

/// One place of a [`Plot::PlaneMap`], mm in the plane, true size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPlace {
    /// Where it was asked to be.
    pub commanded_mm: [f64; 2],
    /// Measured deviation from there.
    pub measured_off_mm: [f64; 2],
    /// Deviation by the errors that were found; `None` on a map of measurements alone.
    pub simulated_off_mm: Option<[f64; 2]>,
}

impl FoundValue {
    /// A value without a remark.
    pub fn new(name: impl Into<String>, value: f64, unit: Unit, u: Option<f64>) -> Self {
        Self { name: name.into(), value, unit, u, note: String::new(), kind: ValueKind::Error }
    }

    /// The same with a remark.
    #[must_use]
    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// The same, about something else than an error.
    #[must_use]
    pub fn kind(self, kind: ValueKind) -> Self {
        Self { kind, ..self }
    }
}

impl Column {
    /// A column of words or plain counts.
    pub fn plain(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: None }
    }

    /// A column of numbers with a unit.
    pub fn of(name: impl Into<String>, unit: Unit) -> Self {
        Self { name: name.into(), unit: Some(unit) }
    }
}

impl Curve {
    /// A curve.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points }
    }
}

impl Plot {
    /// A map with this magnification; without one its largest deviation is drawn at about a quarter of its size, at most 10 000 times as large (S1).
    pub fn plane_map(names: [String; 2], places: Vec<MapPlace>, magnification: Option<f64>) -> Self {
        if let Some(magnification) = magnification {
            return Self::PlaneMap { names, magnification, places };
        }
        let largest = |of: fn(&MapPlace) -> [f64; 2]| {
            let sizes = places.iter().map(|place| of(place)[0].hypot(of(place)[1]));
            sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
        };
        let wanted = 0.25 * largest(|p| p.commanded_mm) / largest(|p| p.measured_off_mm);
        let decade = 10_f64.powf(wanted.log10().floor());
        let round = [5.0, 2.0, 1.0].map(|m| m * decade).into_iter().find(|m| *m <= wanted);
        let magnification = round.filter(|m| m.is_finite()).unwrap_or(1000.0).clamp(10.0, 10_000.0);
        Self::PlaneMap { names, magnification, places }
    }
}

impl Findings {
    /// The value of this name.
    pub fn value(&self, name: &str) -> Option<&FoundValue> {
        self.values.iter().find(|value| value.name == name)
    }
}
