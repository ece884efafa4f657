//! Which data items of the agent this program uses.

use crate::axis_name::letter_of;
use std::collections::BTreeMap;
use trunnion_core::{AxisValues, Joint};
use trunnion_protocol::mtconnect::{Category, DataItem, Device};

/// Data items this program uses, by id.
pub(super) struct Items {
    /// Actual position of each axis.
    pub(super) axes: AxisValues<Option<String>>,
    pub(super) execution: Option<String>,
    pub(super) program: Option<String>,
    pub(super) block: Option<String>,
    pub(super) signal: Option<String>,
    /// Names of the temperatures by id.
    pub(super) temperatures: BTreeMap<String, String>,
}

impl Items {
    /// Finds them; where `named` names a data item by id or name, that one. Else what is missing.
    pub(super) fn find(
        device: &Device,
        named: &AxisValues<Option<String>>,
        signal: Option<&str>,
    ) -> Result<Self, String> {
        let items = &device.data_items;
        let by_name = |wanted: &str| {
            items.iter().find(|item| item.id == wanted || item.name.as_deref() == Some(wanted))
        };
        let mut axes = AxisValues::default();
        for letter in Joint::ISO {
            axes[letter] = match &named[letter] {
                Some(name) => {
                    Some(by_name(name).ok_or(format!("a data item {name} for axis {letter}"))?.id.clone())
                }
                None => {
                    items.iter().filter(|item| is_position(item, letter)).map(|item| item.id.clone()).next()
                }
            };
        }
        if axes.0.iter().all(Option::is_none) {
            return Err(
                "actual positions of axes named X, Y, Z, A, B, C, U, V or W (or name them in `axes`)".into(),
            );
        }
        let signal = match signal {
            Some(name) => Some(by_name(name).ok_or(format!("a data item {name} for the signal"))?.id.clone()),
            None => None,
        };
        let first = |kind: &str| items.iter().find(|item| item.kind == kind).map(|item| item.id.clone());
        let temperatures = items
            .iter()
            .filter(|item| item.category == Category::Sample && item.kind == "TEMPERATURE")
            .map(|item| (item.id.clone(), item.name.clone().unwrap_or_else(|| item.id.clone())))
            .collect();
        Ok(Self {
            axes,
            execution: first("EXECUTION"),
            program: first("PROGRAM"),
            block: first("BLOCK").or_else(|| first("LINE")).or_else(|| first("LINE_NUMBER")),
            signal,
            temperatures,
        })
    }

    /// True of execution, program, block and signal.
    pub(super) fn is_of_controller(&self, id: &str) -> bool {
        [&self.execution, &self.program, &self.block, &self.signal]
            .into_iter()
            .flatten()
            .any(|known| known == id)
    }

    /// The axes found.
    pub(super) fn letters(&self) -> Vec<Joint> {
        Joint::ISO.into_iter().filter(|&letter| self.axes[letter].is_some()).collect()
    }
}

/// Actual position of this axis in machine coordinates.
fn is_position(item: &DataItem, letter: Joint) -> bool {
    let (kind, component) = if letter.is_rotary() { ("ANGLE", "Rotary") } else { ("POSITION", "Linear") };
    let name = Some(item.component.name.as_str()).filter(|name| !name.is_empty());
    item.category == Category::Sample
        && item.kind == kind
        && item.component.kind == component
        && item.sub_type.as_deref().is_none_or(|sub| sub == "ACTUAL")
        && item.coordinate_system.as_deref().is_none_or(|system| system == "MACHINE")
        && name.and_then(letter_of) == Some(letter)
}
