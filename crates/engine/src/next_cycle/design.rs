//! What stays the same for all candidate cycles: the data at hand, the rivals, and the shapes they may take.

use super::information::Part;
use super::present::Present;
use super::rivals::Rivals;
use std::ops::Range;
use trunnion_effects::{Instance, ModelEffect, Scene};

/// Everything that stays the same for all candidates.
pub(super) struct CycleDesign<'a> {
    pub present: &'a Present,
    pub entries: &'a [ModelEffect],
    pub instances: &'a [Instance],
    pub rivals: &'a Rivals,
    pub most_shapes: usize,
    pub separated_ln: f64,
}

/// The parts of a information that belong to one rival: the chosen shape first, then others it may take.
pub(super) struct Shaped<'a> {
    pub parts: Vec<Part<'a>>,
    pub of_rival: Vec<Range<usize>>,
}

impl CycleDesign<'_> {
    pub(super) fn ids(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.id.clone()).collect()
    }

    /// The rivals' parts in a scene: the chosen shapes first where there are any, otherwise those the user gave.
    pub(super) fn shaped(&self, scene: &Scene, chosen: Option<&[Vec<f64>]>) -> Shaped<'_> {
        let (mut parts, mut of_rival) = (Vec::new(), Vec::new());
        for (i, (instance, entry)) in self.instances.iter().zip(self.entries).enumerate() {
            let mut shapes: Vec<Vec<f64>> = Vec::new();
            match chosen.map(|chosen| &chosen[i]) {
                Some(shape) => shapes.push(shape.clone()),
                None if !entry.shape.is_empty() => shapes.push(entry.shape.clone()),
                None => {}
            }
            let shapes_here = instance.shapes(scene);
            let grid = if chosen.is_none() { shapes_here.possible() } else { shapes_here.grid };
            let most = if chosen.is_none() { grid.len() } else { self.most_shapes };
            let stride = grid.len().div_ceil(most.max(1)).max(1);
            for shape in grid.into_iter().skip(stride / 2).step_by(stride) {
                if !shapes.contains(&shape) {
                    shapes.push(shape);
                }
            }
            let first = parts.len();
            parts.extend(shapes.into_iter().map(|shape| Part { instance, shape }));
            of_rival.push(first..parts.len());
        }
        Shaped { parts, of_rival }
    }
}
