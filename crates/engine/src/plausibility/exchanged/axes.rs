//! Probes whose inputs or senses are exchanged, and a nest that is mounted turned.

use crate::Experiment;
use crate::plausibility::fitted::{Fitted, Tried};
use nalgebra::{DVector, Matrix3};
use trunnion_core::number::signed;

/// Names of the probes.
pub(super) const PROBES: [&str; 3] = ["dx", "dy", "dz"];
/// The two probes that a turn about the third mixes.
const ABOUT: [([usize; 2], &str); 3] = [([0, 1], "z"), ([1, 2], "x"), ([2, 0], "y")];
/// A nest mounted turned by less is its calibration (effect `nest-rotation`), °.
const TURNED_DEG: i32 = 10;

/// Every right reading is one of those given, or its negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    /// Which reading is right for each probe.
    from: [usize; 3],
    /// With which sign.
    sign: [f64; 3],
}

/// All but the readings as they are: those with the fewest changes first.
pub(super) fn ways() -> Vec<Way> {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
    let signs = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { -1.0 } else { 1.0 });
    let of_order = |from: [usize; 3]| (0..8).map(move |bits| Way { from, sign: signs(bits) });
    let mut all: Vec<Way> = ORDERS.into_iter().flat_map(of_order).filter(|way| way.changes() > 0).collect();
    all.sort_by_key(Way::changes);
    all
}

impl Way {
    pub fn apply(&self, reading: &mut [f64; 3]) {
        let given = *reading;
        *reading = [0, 1, 2].map(|k| self.sign[k] * given[self.from[k]]);
    }

    fn moved(&self) -> usize {
        (0..3).filter(|&k| self.from[k] != k).count()
    }

    fn reversed(&self) -> Vec<&'static str> {
        (0..3).filter(|&k| self.sign[k] < 0.0).map(|k| PROBES[k]).collect()
    }

    fn changes(&self) -> usize {
        self.moved() + self.reversed().len()
    }

    /// With every sign reversed a model without a direction of gravity fits as well: of two such ways, the one with fewer minus signs.
    pub fn is_first_of_two(&self) -> bool {
        self.reversed().len() < 2 && self.changes() > 0
    }

    pub fn words(&self) -> String {
        match (self.moved(), &self.reversed()[..]) {
            (0, [one]) => format!("the sign of the readings {one} reversed"),
            (0, [a, b]) => format!("the signs of the readings {a} and {b} reversed"),
            (0, _) => "the signs of all readings reversed".into(),
            (2, []) => {
                let moved: Vec<&str> = (0..3).filter(|&k| self.from[k] != k).map(|k| PROBES[k]).collect();
                format!("the readings {} exchanged (probe inputs)", moved.join(" and "))
            }
            _ => {
                let of = |k: usize| {
                    format!("{}{}", if self.sign[k] < 0.0 { "−" } else { "" }, PROBES[self.from[k]])
                };
                format!(
                    "dx, dy, dz read as {} (probe inputs, or the nest mounted turned)",
                    [0, 1, 2].map(of).join(", ")
                )
            }
        }
    }

    /// Of all readings: the opposite of every sign explains as much.
    pub fn words_of_all(&self) -> String {
        let opposite = Self { sign: self.sign.map(|sign| -sign), ..*self };
        match (self.moved(), &opposite.reversed()[..]) {
            (0, [a, b]) => format!("{}, or those of {a} and {b}", self.words()),
            _ => self.words(),
        }
    }
}

/// A nest that is mounted turned about one of its axes: with s = sin, c = cos of the angle, what the model leaves of
/// c·A + s·B + D is a quadratic form in (c, s, 1), which is looked at in steps of a degree.
pub(super) fn turned(experiment: &Experiment, model: &Fitted) -> Vec<Tried> {
    let about = |([first, second], axis): &([usize; 2], &str)| {
        let part = |of: &dyn Fn(&[f64; 3]) -> [f64; 3]| {
            let mut rows = DVector::zeros(experiment.rows());
            for (at, point) in experiment.points.iter().enumerate() {
                experiment.rows_of(at).zip(of(&point.reading_mm)).for_each(|(row, value)| rows[row] = value);
            }
            model.left_mm(&rows)
        };
        let kept = part(&|reading| {
            let mut kept = *reading;
            [kept[*first], kept[*second]] = [0.0; 2];
            kept
        });
        let along = part(&|reading| {
            let mut along = [0.0; 3];
            [along[*first], along[*second]] = [reading[*first], reading[*second]];
            along
        });
        let across = part(&|reading| {
            let mut across = [0.0; 3];
            [across[*first], across[*second]] = [-reading[*second], reading[*first]];
            across
        });
        let parts = [along, across, kept];
        let products = Matrix3::from_fn(|i, j| parts[i].dot(&parts[j]));
        let left_mm = |deg: i32| {
            let (sin, cos) = f64::from(deg).to_radians().sin_cos();
            let at = nalgebra::Vector3::new(cos, sin, 1.0);
            (at.dot(&(products * at)).max(0.0) / experiment.rows().max(1) as f64).sqrt()
        };
        let angles = (-180..180).filter(|deg: &i32| deg.abs() > TURNED_DEG);
        let (deg, left) = angles
            .map(|deg| (deg, left_mm(deg)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f64::INFINITY));
        (format!("the nest mounted turned by {}° about its {axis} axis", signed(f64::from(deg), 0)), left)
    };
    ABOUT.iter().map(about).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_is_there_once_and_the_simplest_come_first() {
        let all = ways();
        assert_eq!(all.len(), 47);
        assert!(all.iter().enumerate().all(|(k, way)| !all[..k].contains(way)));
        assert_eq!(all[0].words(), "the sign of the readings dx reversed");
        assert_eq!(all[0].words_of_all(), "the sign of the readings dx reversed, or those of dy and dz");
        // Of each two that differ in every sign, one: 24 less the readings as they are.
        assert_eq!(all.iter().filter(|way| way.is_first_of_two()).count(), 23);
        let turned = all.iter().find(|way| way.from == [1, 0, 2] && way.sign == [1.0, -1.0, 1.0]).unwrap();
        assert!(turned.words().starts_with("dx, dy, dz read as dy, −dx, dz"), "{}", turned.words());
        let mut reading = [1.0, 2.0, 3.0];
        turned.apply(&mut reading);
        assert_eq!(reading, [2.0, -1.0, 3.0]);
    }
}
