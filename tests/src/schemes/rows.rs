//! The schemes of the sources, one row each. The end-to-end test of the schemes takes this file in by its path.

#[path = "rows/linear.rs"]
mod linear;
#[path = "rows/methods.rs"]
mod methods;
#[path = "rows/rotary.rs"]
mod rotary;
#[path = "rows/row.rs"]
mod row;

pub use row::Row;

/// Every scheme.
pub fn rows() -> impl Iterator<Item = &'static Row> {
    rotary::ROWS.iter().chain(linear::ROWS).chain(methods::ROWS)
}
