//! A nest that is mounted turned by a free angle, and one of which the readings are those of inclined probes, not of its axes.
//!
//! With s = sin, c = cos of the angle, what the model leaves of c·A + s·B + D is a quadratic form in (c, s, 1), which is looked at in steps
//! of a degree.

use super::Trial;
use super::axes::PROBES;
use crate::plausibility::fitted::Tried;
use nalgebra::{Matrix3, Vector3};
use std::ops::RangeInclusive;
use trunnion_core::number::signed;

/// The two probes that a turn about the third mixes.
const ABOUT: [([usize; 2], &str); 3] = [([0, 1], "z"), ([1, 2], "x"), ([2, 0], "y")];
/// A nest mounted turned by less is its calibration (effect `nest-rotation`), °.
const TURNED_DEG: RangeInclusive<i32> = 11..=180;

impl Trial<'_> {
    /// About each of its axes; of one setup, or all.
    pub(super) fn turned(&self, setup: Option<usize>) -> Vec<Tried> {
        ABOUT.iter().map(|about| self.turned_about(*about, setup, TURNED_DEG)).collect()
    }

    /// One setup about z, one way or the other, by an angle of these.
    pub(super) fn turned_about_z(&self, setup: usize, sizes_deg: RangeInclusive<i32>) -> Tried {
        self.turned_about(ABOUT[0], Some(setup), sizes_deg)
    }

    fn turned_about(
        &self,
        (pair, axis): ([usize; 2], &str),
        setup: Option<usize>,
        sizes_deg: RangeInclusive<i32>,
    ) -> Tried {
        let angles = (-180..180).filter(move |deg: &i32| sizes_deg.contains(&deg.abs()));
        let (deg, left_mm) = self.best_turn(setup, pair, angles, |reading| *reading);
        let deg = signed(f64::from(deg), 0);
        (format!("the nest mounted turned by {deg}° about its {axis} axis"), left_mm)
    }

    /// Raw readings of three probes at right angles to each other, each inclined alike to z: their directions are the columns of a rotation, so that
    /// it undoes them. The first stands at any angle about z, the others follow one way round or the other. A nest that looks the other way reads
    /// with all signs reversed, which leaves as much.
    pub(super) fn inclined(&self) -> Vec<Tried> {
        // The angle between the diagonal of a cube and its edges: cos = 1/√3.
        let (along, across) = ((1.0_f64 / 3.0).sqrt(), (2.0_f64 / 3.0).sqrt());
        let cone_deg = along.acos().to_degrees();
        let directions = Matrix3::from_fn(|i, probe| {
            let (sin, cos) = (120.0 * probe as f64).to_radians().sin_cos();
            [across * cos, across * sin, along][i]
        });
        let of_order = |order: [usize; 3]| {
            let change =
                |reading: &[f64; 3]| (directions * Vector3::from(order.map(|probe| reading[probe]))).into();
            let (deg, left_mm) = self.best_turn(None, ABOUT[0].0, -180..180, change);
            let names = order.map(|probe| PROBES[probe]).join(", ");
            let words = format!(
                "{names} taken as raw readings of three probes at right angles, inclined by {cone_deg:.1}° to z, the first at {}° about z",
                signed(f64::from(deg), 0)
            );
            (words, left_mm)
        };
        [[0, 1, 2], [0, 2, 1]].map(of_order).into()
    }

    /// The turn in the plane of two probes with which least is left, ° and mm rms, after a change of each reading.
    fn best_turn(
        &self,
        setup: Option<usize>,
        [first, second]: [usize; 2],
        angles: impl Iterator<Item = i32>,
        change: impl Fn(&[f64; 3]) -> [f64; 3],
    ) -> (i32, f64) {
        let own = self.points_of(setup);
        let part = |of_own: &dyn Fn([f64; 3]) -> [f64; 3], is_kept: bool| {
            let rows = self.changed_rows(|readings| {
                if !is_kept {
                    let mut is_own = vec![false; readings.len()];
                    own.iter().for_each(|&at| is_own[at] = true);
                    let others = readings.iter_mut().zip(is_own).filter(|(_, is_own)| !is_own);
                    others.for_each(|(reading, _)| *reading = [0.0; 3]);
                }
                own.iter().for_each(|&at| readings[at] = of_own(change(&readings[at])));
            });
            self.model.left_mm(&rows)
        };
        let in_plane = |along: f64, across: f64| {
            let mut turned = [0.0; 3];
            [turned[first], turned[second]] = [along, across];
            turned
        };
        let parts = [
            part(&|reading| in_plane(reading[first], reading[second]), false),
            part(&|reading| in_plane(-reading[second], reading[first]), false),
            part(
                &|mut reading| {
                    [reading[first], reading[second]] = [0.0; 2];
                    reading
                },
                true,
            ),
        ];
        let products = Matrix3::from_fn(|i, j| parts[i].dot(&parts[j]));
        let left_mm = |deg: i32| {
            let (sin, cos) = f64::from(deg).to_radians().sin_cos();
            let at = Vector3::new(cos, sin, 1.0);
            (at.dot(&(products * at)).max(0.0) / self.experiment.rows().max(1) as f64).sqrt()
        };
        angles.map(|deg| (deg, left_mm(deg))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    }
}
