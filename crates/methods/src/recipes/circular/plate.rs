//! A circle on a grid plate as a ball bar of its radius would read it.
//!
//! p commanded place of the head in the plane of the plate, c and R centre and radius of its circle; q what the plate reads, q₀ what it would read of the
//! nominal machine: e = q − q₀ less its mean, for the zero lies anywhere; r = ‖p − c + e‖ − R. A turn ψ of the plate moves e along the circle, so it
//! is left with ½ ψ² R: 10 nm of 0.5 mrad at 80 mm.

use crate::geometry::circle;
use nalgebra::{Vector2, Vector3};
use trunnion_core::{InstrumentKind, Point, Setup};
use trunnion_cycles::Run;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors};

/// The run with these points of one setup read by a bar of calibrated length.
///
/// # Errors
/// Commanded places that make no circle.
pub(super) fn by_a_bar(run: &Run, setup: &Setup, points: &[&Point]) -> Result<Run, String> {
    let machine = &run.machine;
    let in_table = |point: &Point| {
        let (position, none) = (&point.state.position, JointErrors::default());
        let head = machine.machine_from_tool(position, &none) * setup.ball_in_tool_mm;
        (machine.machine_from_table(position, &none).inverse() * head).coords
    };
    let [first, second] = setup.gratings();
    let on_plate = |place: &Vector3<f64>| Vector2::new(first.dot(place), second.dot(place));
    let places: Vec<Vector3<f64>> = points.iter().map(|point| in_table(point)).collect();
    let commanded: Vec<Vector2<f64>> = places.iter().map(on_plate).collect();
    let round = circle(&commanded).map_err(|_| "has commanded places that make no circle".to_string())?;
    let off = |point: &&Point| {
        let nominal = predict(machine, setup, &point.state, &Errors::default());
        Vector2::new(point.reading_mm[0] - nominal.x, point.reading_mm[1] - nominal.y)
    };
    let off_mm: Vec<Vector2<f64>> = points.iter().map(off).collect();
    let count = points.len() as f64;
    let zero_mm = off_mm.iter().sum::<Vector2<f64>>() / count;
    let read = |(k, point): (usize, &&Point)| {
        let arm_mm = commanded[k] - round.centre_mm + off_mm[k] - zero_mm;
        Point { reading_mm: [arm_mm.norm() - round.radius_mm, 0.0, 0.0], ..(*point).clone() }
    };
    let middle = places.iter().sum::<Vector3<f64>>() / count;
    let to_centre = round.centre_mm - on_plate(&middle);
    let centre = middle + first.into_inner() * to_centre.x + second.into_inner() * to_centre.y;
    let bar = Setup {
        instrument: InstrumentKind::BallBar,
        ball_in_table_mm: centre.into(),
        bar_length_mm: Some(round.radius_mm),
        direction: None,
        calibrated: true,
        ..setup.clone()
    };
    let mut setups = run.setups.clone();
    if let Some(own) = points.first().and_then(|point| setups.get_mut(point.state.setup)) {
        *own = bar;
    }
    Ok(Run { setups, points: points.iter().enumerate().map(read).collect(), ..run.clone() })
}
