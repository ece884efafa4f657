//! Values of a model as fitted, with their covariance: what a model file keeps so that it predicts runs it was not fitted to.
//!
//! ```toml
//! [effect.values]                                   # in the entry whose adding led to the fit; they are of the whole model
//! date = "2026-03-01"
//! effects = ["location-errors", "ball-setting"]     # the values count while the model holds exactly these
//! reading_um = 0.42
//! runs = [{ name = "tuesday", digest = "crc32:0f3a91c2" }]
//! shapes = { "thermal-drift" = [300.0, 1800.0] }    # inside units
//! parameters = [
//!     { effect = "location-errors", name = "EX0C", unit = "um", value = -3.2, u = 0.26, between_runs = 0.4, correlation = [1.0] },
//!     { effect = "thermal-drift", name = "tau1_s", unit = "s", value = 300.0, u = 40.0, correlation = [0.1, 1.0] },
//! ]
//! ```
//!
//! A shape number that the fit found has its u and correlations among the parameters, after all of them; the shape is that of `shapes`.
//!
//! `correlation` lists ρ with every parameter before it that has u, and with itself. Covariance of the values in one more run:
//! Σ_ij = ρ_ij (u_i u_j + s_i s_j), u the standard uncertainty of the values, s their standard deviation from run to run.
//! Limits: differences between runs are taken to be correlated like the values, as in the one-correlation model of [Riley 2008].

use serde::{Deserialize, Serialize};
use toml_edit::{Array, InlineTable, Item, Table as Written, Value, value};
use trunnion_core::input::Table;

const ANY: std::ops::RangeInclusive<f64> = f64::MIN..=f64::MAX;
const POSITIVE: std::ops::RangeInclusive<f64> = 0.0..=f64::MAX;
const CORRELATION: std::ops::RangeInclusive<f64> = -1.0..=1.0;

/// Values of the machine's parameters in a model, from one fit. Settings are not among them: they belong to a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FittedValues {
    /// Day of the fit, `YYYY-MM-DD`; may be empty.
    pub date: String,
    /// Runs that were fitted.
    pub runs: Vec<FittedRun>,
    /// Ids of the effects of the model that was fitted, in order.
    pub effects: Vec<String>,
    /// Shape numbers (inside units) of the effects that have any.
    pub shapes: Vec<(String, Vec<f64>)>,
    /// Standard deviation of a reading about the model, µm.
    pub reading_um: f64,
    /// Parameters of the machine that are not zero or have a standard uncertainty, then shape numbers that the fit found.
    pub parameters: Vec<FittedValue>,
}

/// A run that was fitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FittedRun {
    /// Name.
    pub name: String,
    /// Digest of its points: the same points have the same one.
    pub digest: String,
}

/// A parameter as fitted, screen units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FittedValue {
    /// Effect id.
    pub effect: String,
    /// Name of the parameter.
    pub name: String,
    /// Unit on files and screens.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty; `None` for a share of a combination that has no number of its own.
    pub u: Option<f64>,
    /// Standard deviation from run to run; `None` where no two runs show it.
    pub between_runs: Option<f64>,
    /// Correlation with the parameters before it that have `u`, and with itself; empty without `u`.
    pub correlation: Vec<f64>,
}

impl FittedValues {
    /// True when these are values of a model that holds exactly these effects.
    pub fn are_of<'a>(&self, effects: impl Iterator<Item = &'a str>) -> bool {
        self.effects.iter().map(String::as_str).eq(effects)
    }

    pub(crate) fn read(table: &Table<'_>) -> Option<Self> {
        let runs = table.tables("runs").iter().map(read_run).collect::<Option<_>>();
        let parameters: Option<Vec<_>> = table.tables("parameters").iter().map(read_value).collect();
        let shapes = table.optional_table("shapes").map_or_else(Vec::new, |shapes| {
            let shape = |name: String| Some((name.clone(), shapes.optional_numbers(&name)?));
            shapes.keys().into_iter().filter_map(shape).collect()
        });
        let (date, effects) = (table.string("date"), table.strings("effects"));
        let reading_um = table.number("reading_um", POSITIVE);
        table.no_other_keys();
        let parameters = parameters?;
        let mut with_u = 0;
        for (parameter, entry) in parameters.iter().zip(table.tables("parameters")) {
            with_u += usize::from(parameter.u.is_some());
            let expected = if parameter.u.is_some() { with_u } else { 0 };
            if parameter.correlation.len() != expected {
                let found = format!("has {} numbers", parameter.correlation.len());
                entry.problem("correlation", found, format!("{expected} numbers"), "fit the model again");
            }
        }
        Some(Self {
            date: date?,
            runs: runs?,
            effects: effects?,
            shapes,
            reading_um: reading_um?,
            parameters,
        })
    }

    pub(crate) fn written(&self) -> Written {
        let mut table = Written::new();
        table["date"] = value(&self.date);
        table["effects"] = value(self.effects.iter().collect::<Array>());
        table["reading_um"] = value(self.reading_um);
        table["runs"] = value(self.runs.iter().map(written_run).collect::<Array>());
        if !self.shapes.is_empty() {
            let array = |numbers: &[f64]| Value::Array(numbers.iter().copied().collect::<Array>());
            let shapes: InlineTable = self.shapes.iter().map(|(name, shape)| (name, array(shape))).collect();
            table["shapes"] = value(shapes);
        }
        let mut parameters: Array = self.parameters.iter().map(written_value).collect();
        parameters.iter_mut().for_each(|item| item.decor_mut().set_prefix("\n    "));
        parameters.set_trailing("\n");
        parameters.set_trailing_comma(!parameters.is_empty());
        table["parameters"] = Item::Value(Value::Array(parameters));
        table
    }
}

fn read_run(table: &Table<'_>) -> Option<FittedRun> {
    let (name, digest) = (table.string("name"), table.string("digest"));
    table.no_other_keys();
    Some(FittedRun { name: name?, digest: digest? })
}

fn written_run(run: &FittedRun) -> InlineTable {
    [("name", run.name.as_str()), ("digest", run.digest.as_str())].into_iter().collect()
}

fn read_value(table: &Table<'_>) -> Option<FittedValue> {
    let [effect, name, unit] = ["effect", "name", "unit"].map(|key| table.string(key));
    let value = table.number("value", ANY);
    let [u, between_runs] = ["u", "between_runs"].map(|key| table.optional_number(key, POSITIVE));
    let correlation = table.optional_numbers("correlation").unwrap_or_default();
    if let Some(wrong) = correlation.iter().find(|rho| !CORRELATION.contains(rho)) {
        table.problem("correlation", format!("holds {wrong}"), "numbers from -1 to 1", "");
    }
    table.no_other_keys();
    let (effect, name, unit, value) = (effect?, name?, unit?, value?);
    Some(FittedValue { effect, name, unit, value, u, between_runs, correlation })
}

fn written_value(parameter: &FittedValue) -> InlineTable {
    let mut inline: InlineTable =
        [("effect", &parameter.effect), ("name", &parameter.name), ("unit", &parameter.unit)]
            .into_iter()
            .map(|(key, text)| (key, text.as_str()))
            .collect();
    inline.insert("value", parameter.value.into());
    for (key, number) in [("u", parameter.u), ("between_runs", parameter.between_runs)] {
        if let Some(number) = number {
            inline.insert(key, number.into());
        }
    }
    if !parameter.correlation.is_empty() {
        inline.insert("correlation", Value::Array(parameter.correlation.iter().copied().collect()));
    }
    inline
}
