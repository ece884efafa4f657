//! Corrections of a machine for its control: one file per control or format of tables.
//!
//! Every one gets the same errors, takes what it can apply and names the rest. Offsets in mm, angles in rad, arguments in mm
//! and degrees, unless the control asks for others.

mod csv;
mod etalon;
mod fanuc;
mod format;
mod heidenhain;
mod isg;
mod lines;
mod linuxcnc;
mod siemens;
mod taken;

pub use format::{Format, Signs};

/// The registry.
pub static FORMATS: &[&Format] = &[
    &csv::FORMAT,
    &etalon::FORMAT,
    &fanuc::FORMAT,
    &heidenhain::FORMAT,
    &isg::FORMAT,
    &linuxcnc::FORMAT,
    &siemens::FORMAT,
];

/// The format of this name.
pub fn format(name: &str) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|format| format.name == name)
}
