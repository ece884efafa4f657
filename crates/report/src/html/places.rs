//! Where the model fails most: the places in words, and the maps that show them best.

use super::maps::{self, Grid, Map};
use crate::markup::{element, escape};
use crate::number::percent;
use crate::words::no_place;
use trunnion_results::{Comparison, Place};

pub fn section(input: &Comparison) -> String {
    let (places, residuals) = (&input.places, &input.residuals);
    let mut body = list(places, no_place(input));
    if let Some(grid) = Grid::of(residuals).filter(|_| !places.is_empty()) {
        let drawn: Vec<Option<Map>> =
            places.iter().map(|place| maps::of_place(residuals, &grid, place)).collect();
        let drawn: Vec<(usize, Map)> =
            drawn.into_iter().enumerate().filter_map(|(i, map)| Some((i + 1, map?))).collect();
        let limit_um = maps::limit_um(drawn.iter().map(|(_, map)| map));
        let figure = |(number, map): &(usize, Map)| {
            map.figure(&grid, limit_um, &format!("Place {number}: {}", map.title))
        };
        body += &format!(
            "<p class=\"soft\">Sizes are means of measured − predicted; X, Y, Z are machine axes unless the table is named. \
                 Each place is framed on the map of its component. {}</p>\n<div class=\"plots\">{}</div>\n",
            maps::KEY,
            drawn.iter().map(figure).collect::<String>()
        );
    }
    format!("<section><h2>Where the model fails most</h2>\n{body}</section>\n")
}

/// The places as a numbered list; `none`: what an empty one means.
pub fn list(places: &[Place], none: &str) -> String {
    if places.is_empty() {
        return element("p", none);
    }
    let item = |place: &Place| {
        format!(
            "<li>{}: <b>{}</b> <span class=\"soft\">({} readings, {} of the residual)</span></li>\n",
            escape(&place.location()),
            escape(&place.size()),
            place.readings,
            percent(place.share)
        )
    };
    format!("<ol>{}</ol>\n", places.iter().map(item).collect::<String>())
}
