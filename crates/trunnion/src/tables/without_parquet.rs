//! In place of Parquet where the program was built without it: there are no rows then.

use crate::Error;
use std::path::Path;

/// None.
pub enum Rows {}

impl Rows {
    /// Why there are none.
    ///
    /// # Errors
    /// Always.
    pub fn begin() -> Result<Self, Error> {
        Err(Error::NoParquet)
    }

    /// Never called.
    ///
    /// # Errors
    /// None.
    pub fn add(&mut self, _: &Path, _: &str) -> Result<(), Error> {
        match *self {}
    }

    /// Never called.
    pub fn count(&self) -> usize {
        match *self {}
    }

    /// Never called.
    ///
    /// # Errors
    /// None.
    pub fn file(&self) -> Result<Vec<u8>, Error> {
        match *self {}
    }
}
