//! A small writer of charts: inline SVG, colours from the page, one file per kind of chart.
//!
//! Every drawing is about 360 units wide, so that on a phone a unit is a pixel and text stays readable.

mod bars;
mod displaced;
mod element;
mod heat_map;
mod key;
mod lattice;
mod mark;
mod path_chart;
mod polar;
mod ranked;
mod scale;
mod xy_chart;

pub use bars::{Bar, bars};
pub use displaced::{Displaced, displaced};
pub use heat_map::{HeatMap, heat_map, legend};
pub use lattice::{Lattice, lattice};
pub use mark::Mark;
pub use path_chart::path_chart;
pub use polar::{Trace, polar};
pub use ranked::{Ranked, ranked};
pub use scale::{end_above, nice_above};
pub use xy_chart::{Series, XyChart, xy_chart};
