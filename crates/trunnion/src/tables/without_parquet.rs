//! In place of Parquet where the program was built without it: says so.

use crate::Error;
use std::path::Path;

/// None.
#[derive(Default)]
pub struct Rows;

impl Rows {
    /// Whether this program can write such files.
    ///
    /// # Errors
    /// Always.
    pub fn begin() -> Result<Self, Error> {
        Err(Error::NoParquet)
    }

    /// None.
    ///
    /// # Errors
    /// Always.
    pub fn add(&mut self, _: &Path, _: &str) -> Result<(), Error> {
        Err(Error::NoParquet)
    }

    /// None.
    pub fn count(&self) -> usize {
        0
    }

    /// None.
    ///
    /// # Errors
    /// Always.
    pub fn write(&self, _: &Path) -> Result<(), Error> {
        Err(Error::NoParquet)
    }
}
