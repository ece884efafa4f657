//! The arithmetic of a fit: rank-revealing least squares, directions without number, line search.

pub(crate) mod collinear;
pub(crate) mod combinations;
pub(crate) mod direction;
pub(crate) mod echelon;
pub(crate) mod golden_section;
pub mod linear;
pub(crate) mod logarithms;
pub(crate) mod normal;
pub(crate) mod null_space;
pub(crate) mod pairs;
pub(crate) mod unseen;
pub mod words;
