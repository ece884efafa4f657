//! What a program is doing, from the numbers, words and bits of servers.

use crate::execution::{OPC_UA_TEXT, Vocabulary};
use crate::signal::signal_of;
use opcua::types::Variant;
use trunnion_core::reading::Execution;

pub(super) fn execution(value: &Variant, numbers: &Vocabulary) -> Execution {
    match value {
        Variant::Boolean(true) => Execution::Active,
        Variant::Boolean(false) => Execution::Ready,
        Variant::String(words) => OPC_UA_TEXT.execution(words.as_ref()),
        other => number(other).map_or(Execution::Unknown, |n| numbers.execution(&n.round().to_string())),
    }
}

/// A number of any size.
pub(super) fn number(value: &Variant) -> Option<f64> {
    let number = match value {
        Variant::SByte(n) => f64::from(*n),
        Variant::Byte(n) => f64::from(*n),
        Variant::Int16(n) => f64::from(*n),
        Variant::UInt16(n) => f64::from(*n),
        Variant::Int32(n) => f64::from(*n),
        Variant::UInt32(n) => f64::from(*n),
        Variant::Int64(n) => *n as f64,
        Variant::UInt64(n) => *n as f64,
        Variant::Float(n) => f64::from(*n),
        Variant::Double(n) => *n,
        _ => return None,
    };
    Some(number).filter(|number| number.is_finite())
}

/// A text; of an array (`ActProgramBlock`: previous, actual, next) the middle.
pub(super) fn text(value: &Variant) -> String {
    match (value, value.as_array()) {
        (_, Some(several)) => several.get(several.len() / 2).map(text).unwrap_or_default(),
        (Variant::String(words), None) => words.as_ref().to_owned(),
        (Variant::Boolean(on), None) => on.to_string(),
        (other, None) => number(other).map(|number| number.to_string()).unwrap_or_default(),
    }
}

/// A signal; `None` when it is no number or bit.
pub(super) fn signal(value: &Variant) -> Option<u32> {
    match value {
        Variant::Boolean(on) => Some(u32::from(*on)),
        other => number(other).map(signal_of),
    }
}
