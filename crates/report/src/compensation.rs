//! Compensation tables of a machine: one file per format.
//!
//! Every format gets the same numbers: offsets in mm, angles in rad, arguments in mm and degrees. The first lines say
//! whether the values are errors or corrections (`correction = −error`), what they come from and what they leave out.

mod csv;
mod etalon;
mod format;
mod isg;

pub use format::Format;

/// The registry.
pub static FORMATS: &[&Format] = &[&csv::FORMAT, &etalon::FORMAT, &isg::FORMAT];

/// The format of this name.
pub fn format(name: &str) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|format| format.name == name)
}
