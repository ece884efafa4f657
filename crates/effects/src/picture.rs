//! A small picture of each effect's signature for `docs/design/catalogue.md`: its `Example` as an instrument would read it.
//!
//! Reading of an R-test with the nest on the table, table axes: R_table⁻¹ (d_tool − d_table) [docs/design/physics.md §1–2]. Readings over
//! poses and turns are shown as they are left after location errors and ball setting have taken their share (least
//! squares), circles after centring and with the mean radius taken off: what a person meets in residuals.

mod svg;
mod views;

use crate::catalogue::REGISTRY;

/// A drawn signature.
pub struct Picture {
    /// File name, `phenomenon.svg`.
    pub file: String,
    /// The drawing.
    pub svg: String,
}

/// One picture for each effect of the catalogue, in registry order.
pub fn catalogue_pictures() -> Vec<Picture> {
    REGISTRY
        .iter()
        .map(|effect| Picture {
            file: format!("{}.svg", effect.phenomenon),
            svg: svg::draw(&views::drawing(effect)),
        })
        .collect()
}
