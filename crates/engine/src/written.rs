//! How a fit is written so that it comes back to the bit: vectors, matrices, and names for what has no numbers.
//!
//! A number that is not finite does not come back: whoever keeps what is written compares it with what it was.

use nalgebra::{DMatrix, DVector};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use trunnion_core::{InstrumentKind, Joint};

/// Numbers one after the other.
pub mod vector {
    use super::*;

    pub fn serialize<S: Serializer>(vector: &DVector<f64>, to: S) -> Result<S::Ok, S::Error> {
        vector.as_slice().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<DVector<f64>, D::Error> {
        Vec::deserialize(from).map(DVector::from_vec)
    }
}

/// Rows, columns, and the numbers column by column.
pub mod matrix {
    use super::*;

    pub fn serialize<S: Serializer>(matrix: &DMatrix<f64>, to: S) -> Result<S::Ok, S::Error> {
        (matrix.nrows(), matrix.ncols(), matrix.as_slice()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<DMatrix<f64>, D::Error> {
        let (rows, columns, numbers) = <(usize, usize, Vec<f64>)>::deserialize(from)?;
        match rows.checked_mul(columns) == Some(numbers.len()) {
            true => Ok(DMatrix::from_vec(rows, columns, numbers)),
            false => Err(D::Error::custom("not as many numbers as the matrix has places")),
        }
    }
}

/// An instrument by its name in files.
pub mod instrument {
    use super::*;

    pub fn serialize<S: Serializer>(kind: &InstrumentKind, to: S) -> Result<S::Ok, S::Error> {
        kind.name().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<InstrumentKind, D::Error> {
        let name = String::deserialize(from)?;
        let named = InstrumentKind::NAMES.into_iter().find(|(known, _)| *known == name);
        named.map(|(_, kind)| kind).ok_or_else(|| D::Error::custom("no instrument has this name"))
    }
}

/// A joint by its letter; one of another name is known to its machine alone, and does not come back.
pub mod joint {
    use super::*;

    pub fn serialize<S: Serializer>(joint: &Joint, to: S) -> Result<S::Ok, S::Error> {
        joint.as_str().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Joint, D::Error> {
        Joint::parse(&String::deserialize(from)?).ok_or_else(|| D::Error::custom("no letter of a joint"))
    }
}
