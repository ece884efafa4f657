//! Points and model, laid out for a fit.

pub mod design;
pub mod experiment;
pub(crate) mod joint;
pub mod passes;
pub(crate) mod stream;
