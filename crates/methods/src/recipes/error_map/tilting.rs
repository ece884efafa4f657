//! Error motions of the tilting axis: what of its map varies beyond constant location errors.
//!
//! xᵢ = eᵢ − cᵢ at the tilts θᵢ, c what the location errors make of the map.
//! Where the axis goes around at enough angles: harmonics, as of the turning axis (`common::harmonics`).
//! On an arc: r = max x − min x as read, which grows with the noise of its extremes. Between the places where the error is truly largest and lowest
//! noise adds a difference of N(0, 2u²) to what is read, and r is no less than that: the true range is at most r + 1.645 √2 u (95 %).
//! r is more than noise makes where r > t √2 u, among all pairs of tilts of all components (`common::significance`).
//! Limits: u by the residual of the map, the largest of all tilts; what drifts from tilt to tilt is not in it.

use super::b_errors::BErrors;
use super::components::components;
use super::grid::Grid;
use super::location::Locations;
use crate::common::harmonics::Harmonics;
use crate::common::significance::is_significant;
use crate::findings::FoundValue;
use crate::recipes::Convention;
use std::f64::consts::SQRT_2;
use trunnion_core::Joint;
use trunnion_core::convert::deg_from_rad;
use trunnion_core::number::signed;
use trunnion_effects::Unit;

/// Of a normal distribution 95 % lie below so many standard deviations.
const BELOW_95: f64 = 1.645;

/// One error motion of the tilting axis.
pub(super) struct Motion {
    /// Its symbol, `EXB`.
    pub name: String,
    pub unit: Unit,
    tilting: Joint,
    /// Tilt and x there, rad and inside units.
    points: Vec<(f64, f64)>,
    /// Standard uncertainty of one x at most.
    u: f64,
    /// Pairs of tilts of all components.
    pairs: usize,
}

/// The six components.
pub(super) fn motions(grid: &Grid<'_>, b_errors: &BErrors, locations: &Locations) -> Vec<Motion> {
    let all = components(grid.tilting);
    let tilts = grid.tilts_rad.len();
    let pairs = all.len() * tilts * tilts.saturating_sub(1) / 2;
    let one = |(name, unit, of): (String, Unit, fn(&trunnion_core::Twist) -> f64)| {
        let beyond = b_errors.at_tilt.iter().zip(&locations.constants).map(|(twist, c)| of(twist) - of(c));
        let points = grid.tilts_rad.iter().copied().zip(beyond).collect();
        let u = b_errors.u_at_tilt.iter().map(of).fold(0.0, f64::max);
        Motion { name, unit, tilting: grid.tilting, points, u, pairs }
    };
    all.into_iter().map(one).collect()
}

impl Motion {
    /// As harmonics, one of so many contours that are judged together; `None` on an arc, or at too few angles.
    pub fn harmonics(&self, contours: usize) -> Option<Harmonics> {
        Harmonics::among(&self.points, contours)
    }

    /// Its range, judged among so many contours; of tilts on an arc S1 prints the ends in degrees (S1 §5.3: coning, αB from −0.013° to +0.013°).
    pub fn value(&self, contours: usize, convention: Convention) -> FoundValue {
        let Self { name, unit, tilting, points, u, pairs } = self;
        if let Some(around) = self.harmonics(contours) {
            let value = around.range_value(name, *unit);
            let note = format!("beyond location errors, without the bias of noise; {}", value.note);
            return value.note(note);
        }
        let values = || points.iter().map(|(_, x)| *x);
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let ends = match convention {
            Convention::Source if *unit == Unit::URAD => {
                format!("from {}° to {}°; ", signed(deg_from_rad(low), 4), signed(deg_from_rad(high), 4))
            }
            _ => String::new(),
        };
        let (as_read, u_difference) = (high - low, SQRT_2 * u);
        let noise = match is_significant(as_read, u_difference, *pairs) {
            true => "more than noise of the readings makes",
            false => "no more than noise of the readings makes",
        };
        let (scale, text) = (unit.per_inside, unit.text());
        let note = format!(
            "{ends}upper bound (95 %); as read {:.2} {text} over {tilting} beyond location errors, {noise}; u of one value at most {:.2} {text}",
            as_read * scale,
            u * scale
        );
        let at_most = as_read + BELOW_95 * u_difference;
        FoundValue::new(format!("{name} range at most"), at_most, *unit, None).note(note)
    }
}
