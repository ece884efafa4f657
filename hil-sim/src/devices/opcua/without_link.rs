//! What a server sends of an axis that was not measured.

use opcua_types::{DataValue, DateTime, StatusCode, Variant};

/// A value of an axis that was not measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WithoutLink {
    /// Null, `BadNoCommunication`.
    #[default]
    BadNull,
    /// A number, `BadSensorFailure`.
    BadNumber,
    /// A number, `UncertainSubstituteValue`.
    Substitute,
    /// Null, `Good`.
    Null,
    /// Not a number, `Good`.
    NotANumber,
}

impl WithoutLink {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::BadNull, Self::BadNumber, Self::Substitute, Self::Null, Self::NotANumber];

    /// The library sees changes of values, not of their status: another number than the last one.
    pub(super) fn value(self, stamp: DateTime) -> DataValue {
        const ELSEWHERE: f64 = -1234.5;
        let (value, status) = match self {
            Self::BadNull => (Variant::Empty, StatusCode::BadNoCommunication),
            Self::BadNumber => (ELSEWHERE.into(), StatusCode::BadSensorFailure),
            Self::Substitute => (ELSEWHERE.into(), StatusCode::UncertainSubstituteValue),
            Self::Null => (Variant::Empty, StatusCode::Good),
            Self::NotANumber => (f64::NAN.into(), StatusCode::Good),
        };
        DataValue::new_at_status(value, stamp, status)
    }
}
