//! Named methods: closed recipes of the literature, one file each, one line in [`REGISTRY`].
//!
//! A method takes runs and returns [`crate::Findings`]; it does what its source does, with the source's slips mended (docs/design/physics.md §8),
//! so that its figures can be compared with the source and with the joint fit. A test walks the directory and the list.

mod ball_bar;
mod circular;
mod convention;
mod error_map;
mod method;
mod multilateration;
mod positioning;
mod quasi_static;
mod rotary_values;
mod roundness;
mod thermal;
mod two_height;

pub use convention::Convention;

pub(crate) use method::one_machine;
pub use method::{Method, MethodError, MethodOptions};

use trunnion_core::names;

/// Every named method.
pub static REGISTRY: &[&Method] = &[
    &two_height::METHOD,
    &error_map::METHOD,
    &rotary_values::METHOD,
    &ball_bar::METHOD,
    &circular::METHOD,
    &positioning::METHOD,
    &thermal::METHOD,
    &quasi_static::METHOD,
    &multilateration::METHOD,
    &roundness::METHOD,
];

/// The method of this name.
///
/// # Errors
/// With every allowed name.
pub fn find(name: &str) -> Result<&'static Method, MethodError> {
    REGISTRY.iter().copied().find(|method| method.name == name).ok_or_else(|| MethodError::Unknown {
        name: name.into(),
        allowed: names::allowed(name, REGISTRY.iter().map(|method| method.name)),
    })
}
