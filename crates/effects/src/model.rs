//! The model: the effects in the order they were added. File format `trunnion-model/1` (docs/design/contracts.md §4).
//!
//! ```toml
//! format = "trunnion-model/1"
//! machine = "table-bc"
//!
//! [[effect]]
//! id = "location-errors"
//! fixed = { EX0B = 3.0 }                            # screen units (here µm)
//! prior = { EA0C = { value = 0.0, u = 20.0 } }
//!
//! [[effect]]
//! id = "thermal-drift"
//! shape = [300.0, 1800.0]
//! [effect.ladder]
//! date = "2026-03-01"
//! run = "tuesday"
//! error_before_um = 4.1
//! error_after_um = 1.2
//! noise_um = 0.9
//! evidence = 12.4                                   # as a diagnosis proposed it, with what was confounded with it then
//! confused_with = ["backlash:B"]
//! separate_by = "Approach each pose from both sides."
//! [effect.ladder.moved]                             # what it did to the other parameters, screen units
//! EX0C = { before = -3.2, after = -1.1, u = 0.26, unit = "um" }
//! [effect.values]                                   # of the whole model, see `FittedValues`
//!
//! [[effect]]
//! id = "formula:hose"
//! site = "axis:B"
//! component = "ea"
//! expression = "pull * step(B - start)"
//! grid = { start = [0.2, 0.4, 0.6] }
//!
//! [[removed]]                                       # taken out again
//! effect = "backlash:C"
//! date = "2026-03-02"
//! by = "Ada"
//! ```

use crate::catalogue::LOCATION_ERRORS;
use crate::{FittedValues, Formula, LadderRow, ModelEffect, Moved, Prior, Removal};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table as Written, Value, value};
use trunnion_core::input::{Document, Table};
use trunnion_core::{Problem, Problems};

/// A model: machine name and effects in the order they were added.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Machine name or path.
    pub machine: String,
    /// Entries in the order they were added.
    pub effects: Vec<ModelEffect>,
    /// What was taken out again, in order.
    pub removed: Vec<Removal>,
}

const FORMAT: &str = "trunnion-model/1";
const ANY: std::ops::RangeInclusive<f64> = f64::MIN..=f64::MAX;

impl Model {
    /// `location-errors` and `ball-setting` alone.
    pub fn base(machine: &str) -> Self {
        let entry = |id: &str| ModelEffect { id: id.into(), ..ModelEffect::default() };
        Self::of(machine, crate::catalogue::BASE.map(entry).into())
    }

    /// These effects; nothing was removed.
    pub fn of(machine: &str, effects: Vec<ModelEffect>) -> Self {
        Self { machine: machine.into(), effects, removed: Vec::new() }
    }

    /// Reads a model file; `file` is the name shown in problems. Whether the machine can have the effects is for
    /// [`crate::Instance::from_model_effect`] to say.
    ///
    /// # Errors
    /// Every problem of the file, with line, what was found and what is allowed.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(file, text)?;
        let model = read(&document);
        document.finish(model)
    }

    /// The model as a new file.
    pub fn to_text(&self) -> String {
        let mut document = DocumentMut::new();
        document["format"] = value(FORMAT);
        document["machine"] = value(&self.machine);
        document["effect"] = Item::ArrayOfTables(self.effects.iter().map(written).collect());
        if !self.removed.is_empty() {
            document["removed"] = Item::ArrayOfTables(self.removed.iter().map(Removal::written).collect());
        }
        document.to_string()
    }

    /// The text of a model file with one more entry; comments and order of what is there stay as they are.
    ///
    /// # Errors
    /// When `text` is no TOML or its `effect` is no `[[effect]]` list.
    pub fn append(text: &str, entry: &ModelEffect) -> Result<String, Problems> {
        edited(text, "effect", |effects| effects.push(written(entry)))
    }

    /// The text of a model file without the entry `id`; everything else stays as it is.
    ///
    /// # Errors
    /// When `text` is no TOML or its `effect` is no `[[effect]]` list.
    pub fn without(text: &str, id: &str) -> Result<String, Problems> {
        edited(text, "effect", |effects| effects.retain(|table| !is_entry(table, id)))
    }

    /// The text of a model file with a removal more; everything else stays as it is.
    ///
    /// # Errors
    /// When `text` is no TOML or its `removed` is no `[[removed]]` list.
    pub fn with_removal(text: &str, removal: &Removal) -> Result<String, Problems> {
        edited(text, "removed", |removed| removed.push(removal.written()))
    }

    /// The text of a model file with the ladder row of the entry `id` replaced; everything else stays as it is.
    ///
    /// # Errors
    /// When `text` is no TOML or its `effect` is no `[[effect]]` list.
    pub fn with_ladder_row(text: &str, id: &str, row: &LadderRow) -> Result<String, Problems> {
        edited(text, "effect", |effects| {
            for table in effects.iter_mut().filter(|table| is_entry(table, id)) {
                table["ladder"] = Item::Table(written_ladder(row));
            }
        })
    }

    /// The text of a model file with values in its last entry; everything else stays as it is.
    ///
    /// # Errors
    /// When `text` is no TOML or its `effect` is no `[[effect]]` list.
    pub fn with_values(text: &str, values: &FittedValues) -> Result<String, Problems> {
        edited(text, "effect", |effects| {
            if let Some(last) = effects.iter_mut().last() {
                last["values"] = Item::Table(values.written());
            }
        })
    }

    /// The values that its last fit left in the file; `None` when there are none, or when they are of other effects.
    pub fn values(&self) -> Option<&FittedValues> {
        let last = self.effects.last()?.values.as_ref()?;
        last.are_of(self.effects.iter().map(|entry| entry.id.as_str())).then_some(last)
    }
}

fn is_entry(table: &Written, id: &str) -> bool {
    table.get("id").and_then(Item::as_str) == Some(id)
}

/// The text of a model file with its `[[effect]]` list, or that of this name, changed.
fn edited(text: &str, list: &str, change: impl FnOnce(&mut ArrayOfTables)) -> Result<String, Problems> {
    let problem = |found: String, allowed: &str| Problem {
        file: "model".into(),
        line: 0,
        column: 0,
        found,
        allowed: allowed.into(),
        advice: String::new(),
    };
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| problem(error.to_string(), "TOML 1.0"))?;
    let effects = document.entry(list).or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    let Some(effects) = effects.as_array_of_tables_mut() else {
        return Err(problem(format!("{list} is no list of tables"), "a list of tables").into());
    };
    change(effects);
    Ok(document.to_string())
}

fn read(document: &Document<'_>) -> Option<Model> {
    let root = document.root();
    let format = root.format(FORMAT);
    let machine = root.string("machine");
    let effects: Vec<Option<ModelEffect>> = root.tables("effect").iter().map(read_effect).collect();
    let removed: Vec<Option<Removal>> = root.tables("removed").iter().map(Removal::read).collect();
    root.no_other_keys();
    // Without them the other effects take their place, and a table of location errors would be empty.
    if !effects.iter().flatten().any(|entry| entry.id == LOCATION_ERRORS) {
        root.problem(
            "effect",
            format!("holds no {LOCATION_ERRORS}"),
            format!("a model with id = \"{LOCATION_ERRORS}\", which every model has"),
            "Put [[effect]] with this id before the others.",
        );
    }
    for (i, entry) in effects.iter().enumerate() {
        let Some(entry) = entry else { continue };
        if effects[..i].iter().flatten().any(|earlier| earlier.id == entry.id) {
            root.tables("effect")[i].problem(
                "id",
                format!("= \"{}\" is there twice", entry.id),
                "each effect once",
                "",
            );
        }
    }
    format?;
    let effects = effects.into_iter().collect::<Option<_>>()?;
    Some(Model { machine: machine?, effects, removed: removed.into_iter().collect::<Option<_>>()? })
}

fn read_effect(table: &Table<'_>) -> Option<ModelEffect> {
    let id = table.string("id");
    let is_formula = id.as_deref().and_then(Formula::name_of).is_some();
    let texts = ["site", "component", "expression"].map(|key| {
        if is_formula {
            return table.string(key);
        }
        if table.has(key) {
            table.problem(key, "belongs to a formula", "only with id = \"formula:NAME\"", "");
        }
        None
    });
    let [site, component, expression] = texts;
    let entry = ModelEffect {
        id: id.unwrap_or_default(),
        shape: table.optional_numbers("shape").unwrap_or_default(),
        fixed: named(table, "fixed", |values, name| values.number(name, ANY)),
        prior: named(table, "prior", |values, name| {
            let prior = values.table(name)?;
            let (value, u) = (prior.number("value", ANY), prior.number("u", f64::MIN_POSITIVE..=f64::MAX));
            prior.no_other_keys();
            Some(Prior { value: value?, u: u? })
        }),
        grid: if is_formula {
            named(table, "grid", |values, name| {
                let numbers = values.optional_numbers(name)?;
                if numbers.is_empty() {
                    values.problem(name, "is empty", "at least one number", "");
                }
                Some(numbers)
            })
        } else {
            Vec::new()
        },
        ladder: table.optional_table("ladder").and_then(|ladder| read_ladder(&ladder)),
        values: table.optional_table("values").and_then(|values| FittedValues::read(&values)),
        site,
        component,
        expression,
    };
    table.no_other_keys();
    if entry.id.is_empty() {
        return None;
    }
    Some(entry)
}

/// The entries of a sub-table by name, in file order.
fn named<T>(table: &Table<'_>, key: &str, read: impl Fn(&Table<'_>, &str) -> Option<T>) -> Vec<(String, T)> {
    let Some(values) = table.optional_table(key) else { return Vec::new() };
    values.keys().into_iter().filter_map(|name| read(&values, &name).map(|v| (name, v))).collect()
}

fn read_ladder(table: &Table<'_>) -> Option<LadderRow> {
    let error = 0.0..=f64::MAX;
    let row = LadderRow {
        date: table.string("date").unwrap_or_default(),
        by: table.optional_string("by"),
        with: table.optional_string("with"),
        run: table.string("run").unwrap_or_default(),
        error_before_um: table.number("error_before_um", error.clone()).unwrap_or_default(),
        error_after_um: table.number("error_after_um", error.clone()).unwrap_or_default(),
        holdout_before_um: table.optional_number("holdout_before_um", error.clone()),
        holdout_after_um: table.optional_number("holdout_after_um", error.clone()),
        holdout_unit: table.optional_string("holdout_unit"),
        noise_um: table.optional_number("noise_um", error.clone()),
        moved: named(table, "moved", |values, name| {
            let moved = values.table(name)?;
            let [before, after] = ["before", "after"].map(|key| moved.number(key, ANY));
            let (u, unit) = (moved.number("u", error.clone()), moved.string("unit"));
            moved.no_other_keys();
            Some(Moved { name: name.into(), before: before?, after: after?, u: u?, unit: unit? })
        })
        .into_iter()
        .map(|(_, moved)| moved)
        .collect(),
        evidence: table.optional_number("evidence", ANY),
        confused_with: table.optional_strings("confused_with").unwrap_or_default(),
        separate_by: table.optional_string("separate_by").unwrap_or_default(),
        found_with: table.optional_strings("found_with").unwrap_or_default(),
    };
    table.no_other_keys();
    Some(row)
}

fn written(entry: &ModelEffect) -> Written {
    let mut table = Written::new();
    table["id"] = value(&entry.id);
    for (key, text) in
        [("site", &entry.site), ("component", &entry.component), ("expression", &entry.expression)]
    {
        if let Some(text) = text {
            table[key] = value(text);
        }
    }
    let array = |numbers: &[f64]| Value::Array(numbers.iter().copied().collect::<Array>());
    if !entry.shape.is_empty() {
        table["shape"] = value(array(&entry.shape));
    }
    let mut put = |key: &str, inline: InlineTable| {
        if !inline.is_empty() {
            table[key] = value(inline);
        }
    };
    put("grid", entry.grid.iter().map(|(name, numbers)| (name, array(numbers))).collect());
    put("fixed", entry.fixed.iter().map(|(name, number)| (name, Value::from(*number))).collect());
    let prior =
        |prior: &Prior| -> InlineTable { [("value", prior.value), ("u", prior.u)].into_iter().collect() };
    put("prior", entry.prior.iter().map(|(name, p)| (name, Value::InlineTable(prior(p)))).collect());
    if let Some(row) = &entry.ladder {
        table["ladder"] = Item::Table(written_ladder(row));
    }
    if let Some(values) = &entry.values {
        table["values"] = Item::Table(values.written());
    }
    table
}

fn written_ladder(row: &LadderRow) -> Written {
    let mut table = Written::new();
    table["date"] = value(&row.date);
    if let Some(by) = &row.by {
        table["by"] = value(by);
    }
    if let Some(with) = &row.with {
        table["with"] = value(with);
    }
    table["run"] = value(&row.run);
    let numbers = [
        ("error_before_um", Some(row.error_before_um)),
        ("error_after_um", Some(row.error_after_um)),
        ("holdout_before_um", row.holdout_before_um),
        ("holdout_after_um", row.holdout_after_um),
        ("noise_um", row.noise_um),
        ("evidence", row.evidence),
    ];
    for (key, number) in numbers {
        if let Some(number) = number {
            table[key] = value(rounded(number));
        }
    }
    if let Some(unit) = &row.holdout_unit {
        table["holdout_unit"] = value(unit);
    }
    if !row.confused_with.is_empty() {
        table["confused_with"] = value(row.confused_with.iter().map(String::as_str).collect::<Array>());
    }
    if !row.separate_by.is_empty() {
        table["separate_by"] = value(&row.separate_by);
    }
    if !row.found_with.is_empty() {
        table["found_with"] = value(row.found_with.iter().map(String::as_str).collect::<Array>());
    }
    if !row.moved.is_empty() {
        let mut moved = Written::new();
        for m in &row.moved {
            let numbers = [("before", m.before), ("after", m.after), ("u", m.u)];
            let mut inline: InlineTable =
                numbers.into_iter().map(|(key, number)| (key, Value::from(rounded(number)))).collect();
            inline.insert("unit", Value::from(m.unit.as_str()));
            moved[&m.name] = value(inline);
        }
        table["moved"] = Item::Table(moved);
    }
    table
}

/// Nine digits, as of kept values: rounded again for a screen it is the figure of the fit itself.
fn rounded(number: f64) -> f64 {
    format!("{number:.8e}").parse().unwrap_or(number)
}

mod on_machine;
#[cfg(test)]
mod tests;
