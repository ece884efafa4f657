//! What a program is doing, from the numbers, words and bits of servers.

use opcua::types::Variant;
use trunnion_core::reading::Execution;

/// Whose numbers they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// `progStatus` of SINUMERIK: 1 interrupted, 2 stopped, 3 in progress, 4 waiting, 5 aborted. Programs of others read 2 and 3
    /// so too; 1, 4 and 5 are not confirmed.
    Sinumerik,
    /// `CncChannelProgramStatus` of OPC 40502 §7.2.5: 0 stopped, 1 running, 2 waiting, 3 interrupted, 4 cancelled.
    Opc40502,
}

pub(super) fn execution(value: &Variant, numbers: Numbers) -> Execution {
    match value {
        Variant::Boolean(runs) => {
            if *runs {
                Execution::Active
            } else {
                Execution::Ready
            }
        }
        Variant::String(words) => match words.as_ref().to_lowercase().as_str() {
            "active" | "running" | "waiting" => Execution::Active,
            "interrupted" | "held" | "feed_hold" => Execution::Held,
            "stopped" | "canceled" | "cancelled" | "aborted" | "completed" => Execution::Ended,
            "ready" | "idle" | "reset" => Execution::Ready,
            _ => Execution::Unknown,
        },
        other => match (numbers, number(other).map(|number| number.round() as i64)) {
            (Numbers::Sinumerik, Some(3 | 4)) | (Numbers::Opc40502, Some(1 | 2)) => Execution::Active,
            (Numbers::Sinumerik, Some(1 | 2)) | (Numbers::Opc40502, Some(3)) => Execution::Held,
            (Numbers::Sinumerik, Some(5)) | (Numbers::Opc40502, Some(0 | 4)) => Execution::Ended,
            _ => Execution::Unknown,
        },
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
pub(super) fn is_on(value: &Variant) -> Option<bool> {
    match value {
        Variant::Boolean(on) => Some(*on),
        other => number(other).map(|number| number != 0.0),
    }
}
