//! Reading hand-written TOML: parse once, report every problem with its line, then trust.
//!
//! A [`Document`] holds the text; a [`Table`] hands out typed values by key and notes each problem;
//! [`Document::finish`] turns the notes into `Problems`. Keys nobody asked for are problems too, so a
//! misspelt key is never silently ignored.

use crate::Day;
use crate::names;
use crate::problem::{Problem, Problems};
use nalgebra::Vector3;
use std::cell::RefCell;
use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What a key of a day may hold.
const DAY: &str = "a day such as 2026-11-23";

/// A TOML file being read, with the problems found so far.
pub struct Document<'a> {
    file: &'a str,
    text: &'a str,
    root: DeTable<'a>,
    problems: RefCell<Vec<Problem>>,
}

impl<'a> Document<'a> {
    /// Parses the syntax of `text`; `file` is the name shown in problems.
    pub fn parse(file: &'a str, text: &'a str) -> Result<Self, Problems> {
        let root = DeTable::parse(text).map_err(|error| {
            let (line, column) = error.span().map_or((0, 0), |span| line_and_column(text, span.start));
            Problem {
                file: file.into(),
                line,
                column,
                found: error.message().replace('\n', " "),
                allowed: "TOML 1.0".into(),
                advice: String::new(),
            }
        })?;
        Ok(Self { file, text, root: root.into_inner(), problems: RefCell::default() })
    }

    /// The top-level table.
    pub fn root(&self) -> Table<'_> {
        Table {
            document: self,
            table: &self.root,
            path: String::new(),
            span: 0..0,
            asked: RefCell::default(),
        }
    }

    /// `value` if no problem was noted, else all problems in file order.
    pub fn finish<T>(self, value: Option<T>) -> Result<T, Problems> {
        let mut problems = self.problems.into_inner();
        problems.sort_by_key(|problem| (problem.line, problem.column));
        problems.dedup();
        match value {
            Some(value) if problems.is_empty() => Ok(value),
            _ if problems.is_empty() => Err(Problem {
                file: self.file.into(),
                line: 0,
                column: 0,
                found: "incomplete".into(),
                allowed: String::new(),
                advice: String::new(),
            }
            .into()),
            _ => Err(Problems(problems)),
        }
    }

    fn note(&self, at: Range<usize>, found: String, allowed: String, advice: &str) {
        let (line, column) = if at.is_empty() { (0, 0) } else { line_and_column(self.text, at.start) };
        let advice = advice.into();
        self.problems.borrow_mut().push(Problem {
            file: self.file.into(),
            line,
            column,
            found,
            allowed,
            advice,
        });
    }
}

/// One table of a [`Document`].
pub struct Table<'d> {
    document: &'d Document<'d>,
    table: &'d DeTable<'d>,
    path: String,
    span: Range<usize>,
    asked: RefCell<Vec<String>>,
}

impl<'d> Table<'d> {
    /// Folder of the file.
    pub fn folder(&self) -> PathBuf {
        Path::new(self.document.file).parent().map(Path::to_owned).unwrap_or_default()
    }

    /// Notes a problem with `key` (or with the table, when the key is absent).
    pub fn problem(&self, key: &str, found: impl Display, allowed: impl Display, advice: &str) {
        let span = self.table.get(key).map_or(self.span.clone(), Spanned::span);
        self.document.note(span, format!("{}{key} {found}", self.path), allowed.to_string(), advice);
    }

    /// True when the key is present; counts as asked.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// True when the key is present with an array; counts as asked.
    pub fn is_array(&self, key: &str) -> bool {
        self.get(key).is_some_and(|value| matches!(value.get_ref(), DeValue::Array(_)))
    }

    /// Keys in file order, without counting them as asked.
    pub fn keys(&self) -> Vec<String> {
        let mut keys: Vec<_> =
            self.table.iter().map(|(k, _)| (k.span().start, k.get_ref().to_string())).collect();
        keys.sort();
        keys.into_iter().map(|(_, key)| key).collect()
    }

    /// A required string.
    pub fn string(&self, key: &str) -> Option<String> {
        self.require(key, "a string").and_then(|_| self.optional_string(key))
    }

    /// A string, if present.
    pub fn optional_string(&self, key: &str) -> Option<String> {
        match self.get(key)?.get_ref() {
            DeValue::String(s) => Some(s.to_string()),
            other => self.wrong(key, other, "a string"),
        }
    }

    /// A required string out of `allowed`.
    pub fn one_of(&self, key: &str, allowed: &[&str]) -> Option<String> {
        let value = self.string(key)?;
        self.check_one_of(key, value, allowed)
    }

    /// A string out of `allowed`, if present.
    pub fn optional_one_of(&self, key: &str, allowed: &[&str]) -> Option<String> {
        let value = self.optional_string(key)?;
        self.check_one_of(key, value, allowed)
    }

    /// A day, if present: a date of TOML, or the same as a string.
    pub fn optional_day(&self, key: &str) -> Option<Day> {
        let (day, found) = match self.get(key)?.get_ref() {
            DeValue::Datetime(date) => (Day::of(*date), date.to_string()),
            DeValue::String(text) => (Day::parse(text), format!("\"{text}\"")),
            other => return self.wrong(key, other, DAY),
        };
        if day.is_none() {
            self.problem(key, format!("= {found}"), DAY, "");
        }
        day
    }

    /// A required number within `allowed`.
    pub fn number(&self, key: &str, allowed: RangeInclusive<f64>) -> Option<f64> {
        self.require(key, "a number").and_then(|_| self.optional_number(key, allowed))
    }

    /// A number within `allowed`, if present.
    pub fn optional_number(&self, key: &str, allowed: RangeInclusive<f64>) -> Option<f64> {
        let value = self.get(key)?;
        let Some(number) = number_of(value.get_ref()) else {
            return self.wrong(key, value.get_ref(), "a number");
        };
        if allowed.contains(&number) {
            return Some(number);
        }
        let text = format!("{}..={}", allowed.start(), allowed.end());
        self.problem(key, format!("= {number}"), text, "");
        None
    }

    /// A count in `allowed`, when present.
    pub fn optional_count(&self, key: &str, allowed: RangeInclusive<f64>) -> Option<f64> {
        let number = self.optional_number(key, allowed)?;
        if number.fract() == 0.0 {
            return Some(number);
        }
        self.problem(key, format!("= {number}"), "a whole number", "");
        None
    }

    /// A boolean, or `default` when absent.
    pub fn boolean_or(&self, key: &str, default: bool) -> Option<bool> {
        match self.get(key).map(Spanned::get_ref) {
            None => Some(default),
            Some(DeValue::Boolean(b)) => Some(*b),
            Some(other) => self.wrong(key, other, "true or false"),
        }
    }

    /// A required array of three numbers.
    pub fn vector3(&self, key: &str) -> Option<Vector3<f64>> {
        self.require(key, "three numbers").and_then(|_| self.optional_vector3(key))
    }

    /// An array of three numbers, if present.
    pub fn optional_vector3(&self, key: &str) -> Option<Vector3<f64>> {
        let numbers = self.optional_numbers(key)?;
        if let [x, y, z] = numbers[..] {
            return Some(Vector3::new(x, y, z));
        }
        self.problem(key, format!("has {} numbers", numbers.len()), "three numbers, [x, y, z]", "");
        None
    }

    /// An array of finite numbers, if present.
    pub fn optional_numbers(&self, key: &str) -> Option<Vec<f64>> {
        let value = self.get(key)?;
        let DeValue::Array(array) = value.get_ref() else {
            return self.wrong(key, value.get_ref(), "an array of numbers");
        };
        let numbers: Option<Vec<f64>> = array.iter().map(|item| number_of(item.get_ref())).collect();
        if numbers.is_none() {
            return self.wrong(key, value.get_ref(), "an array of numbers");
        }
        numbers
    }

    /// A required array of strings.
    pub fn strings(&self, key: &str) -> Option<Vec<String>> {
        self.require(key, "an array of strings").and_then(|_| self.optional_strings(key))
    }

    /// An array of strings, if present.
    pub fn optional_strings(&self, key: &str) -> Option<Vec<String>> {
        let value = self.get(key)?;
        let strings = match value.get_ref() {
            DeValue::Array(array) => array
                .iter()
                .map(|item| match item.get_ref() {
                    DeValue::String(s) => Some(s.to_string()),
                    _ => None,
                })
                .collect(),
            _ => None,
        };
        if strings.is_none() {
            return self.wrong(key, value.get_ref(), "an array of strings");
        }
        strings
    }

    /// A sub-table; noted as missing when absent.
    pub fn table(&self, key: &str) -> Option<Table<'d>> {
        self.require(key, "a table").and_then(|_| self.optional_table(key))
    }

    /// A sub-table, if present.
    pub fn optional_table(&self, key: &str) -> Option<Table<'d>> {
        let value = self.get(key)?;
        match value.get_ref() {
            DeValue::Table(table) => Some(self.child(key, None, table, value.span())),
            other => self.wrong(key, other, "a table"),
        }
    }

    /// The tables of an array of tables (`[[key]]`); empty when absent.
    pub fn tables(&self, key: &str) -> Vec<Table<'d>> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let DeValue::Array(array) = value.get_ref() else {
            self.wrong::<()>(key, value.get_ref(), &format!("an array of tables, [[{key}]]"));
            return Vec::new();
        };
        let mut tables = Vec::new();
        for (i, item) in array.iter().enumerate() {
            match item.get_ref() {
                DeValue::Table(table) => tables.push(self.child(key, Some(i), table, item.span())),
                other => {
                    self.wrong::<()>(key, other, &format!("tables, [[{key}]]"));
                }
            }
        }
        tables
    }

    /// The `format` line: exactly `expected`.
    pub fn format(&self, expected: &str) -> Option<()> {
        let found = self.string("format")?;
        if found == expected {
            return Some(());
        }
        self.problem("format", format!("= \"{found}\""), format!("\"{expected}\""), "");
        None
    }

    /// Notes every key nobody asked for. Call when all known keys have been read.
    pub fn no_other_keys(&self) {
        let asked = self.asked.borrow();
        for (key, _) in self.table {
            if !asked.iter().any(|known| known == key.get_ref()) {
                let allowed = names::allowed(key.get_ref(), asked.iter());
                self.document.note(
                    key.span(),
                    format!("{}{} is not known here", self.path, key.get_ref()),
                    allowed,
                    "",
                );
            }
        }
    }

    fn get(&self, key: &str) -> Option<&'d Spanned<DeValue<'d>>> {
        let mut asked = self.asked.borrow_mut();
        if !asked.iter().any(|known| known == key) {
            asked.push(key.into());
        }
        self.table.get(key)
    }

    /// Notes a key that is missing; `None` then.
    pub fn require(&self, key: &str, expected: &str) -> Option<()> {
        if self.get(key).is_some() {
            return Some(());
        }
        let place = if self.path.is_empty() {
            String::new()
        } else {
            format!(" in [{}]", self.path.trim_end_matches('.'))
        };
        self.document.note(self.span.clone(), format!("{key} is missing{place}"), expected.into(), "");
        None
    }

    fn child(
        &self,
        key: &str,
        index: Option<usize>,
        table: &'d DeTable<'d>,
        span: Range<usize>,
    ) -> Table<'d> {
        let index = index.map_or(String::new(), |i| format!("[{i}]"));
        Table {
            document: self.document,
            table,
            path: format!("{}{key}{index}.", self.path),
            span,
            asked: RefCell::default(),
        }
    }

    fn check_one_of(&self, key: &str, value: String, allowed: &[&str]) -> Option<String> {
        if allowed.contains(&value.as_str()) {
            return Some(value);
        }
        self.problem(key, format!("= \"{value}\""), names::allowed(&value, allowed), "");
        None
    }

    fn wrong<T>(&self, key: &str, found: &DeValue<'_>, expected: &str) -> Option<T> {
        self.problem(key, format!("is {}", found.type_str()), expected, "");
        None
    }
}

fn number_of(value: &DeValue<'_>) -> Option<f64> {
    let number = match value {
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok()? as f64,
        DeValue::Float(x) => x.as_str().parse().ok()?,
        _ => return None,
    };
    number.is_finite().then_some(number)
}

fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|&&byte| byte != b'\n').count() + 1;
    (line, column)
}

#[cfg(test)]
mod tests;
