//! Jogs of the machine against the directions of the nest: which probe is turned, which are exchanged.
//! p_k = s_k · (d_π(k) · Δ)                                                     [S1 §3.2, see nest]
//! p_k change of probe k over a jog, mm; Δ displacement of the ball, nest axes; d directions of the nest; π order and s signs of
//! the probes. Of the 48 pairs (π, s) those that agree with the jogs are kept, the fewest changes first.
//! Limits: one jog along one axis sees only what its directions differ in; ties are stated.

use crate::nest::{NestCalibration, NestStep};
use nalgebra::Vector3;

/// A probe that is turned is off by twice its change, one that is exchanged by the difference of two directions; directions and gains of
/// a calibrated nest are right to some percent. The limit lies between, as a share of the change that is expected.
const AGREES: f64 = 0.25;

/// Orders of three probes, by the number of those that change their place.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [2, 1, 0], [1, 0, 2], [1, 2, 0], [2, 0, 1]];

/// How the probes stand, seen from the nest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Probe k reads along direction `order[k]`.
    pub order: [usize; 3],
    /// Probe k reads against it.
    pub turned: [bool; 3],
}

/// What jogs say.
#[derive(Clone, Debug, PartialEq)]
pub struct JogAnswer {
    /// What each probe was expected to change by in each jog, mm.
    pub expected_mm: Vec<[f64; 3]>,
    /// Every way to stand that agrees, the fewest changes first; empty when none does.
    pub agreeing: Vec<Standing>,
}

impl Standing {
    /// As the nest says.
    pub const AS_NEST: Self = Self { order: [0, 1, 2], turned: [false; 3] };

    fn every() -> impl Iterator<Item = Self> {
        let signs = (0..8).map(|bits| [0, 1, 2].map(|k| bits >> k & 1 == 1));
        signs.flat_map(|turned| ORDERS.map(|order| Self { order, turned }))
    }

    fn changes(self) -> usize {
        (0..3).filter(|&k| self.order[k] != k || self.turned[k]).count()
    }

    fn expects_mm(self, along_mm: &Vector3<f64>) -> Vector3<f64> {
        let one = |k: usize| if self.turned[k] { -along_mm[self.order[k]] } else { along_mm[self.order[k]] };
        Vector3::new(one(0), one(1), one(2))
    }
}

/// Compares jogs, displacements of the ball with the changes of the probes, with the nest; `None` for a nest that cannot be inverted
/// or without jogs.
pub fn judge_jogs(nest: &NestCalibration, jogs: &[NestStep]) -> Option<JogAnswer> {
    let probes_from_nest = nest.nest_from_probes.try_inverse()?;
    let along: Vec<Vector3<f64>> = jogs.iter().map(|jog| probes_from_nest * jog.ball_in_nest_mm).collect();
    let size = along.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
    if size <= 0.0 {
        return None;
    }
    let off = |standing: Standing| {
        let one = |(along, jog): (&Vector3<f64>, &NestStep)| {
            (Vector3::from(jog.probes_mm) - standing.expects_mm(along)).norm_squared()
        };
        along.iter().zip(jogs).map(one).sum::<f64>().sqrt()
    };
    let mut agreeing: Vec<Standing> =
        Standing::every().filter(|&standing| off(standing) <= AGREES * size).collect();
    agreeing.sort_by_key(|standing| standing.changes());
    Some(JogAnswer { expected_mm: along.into_iter().map(Into::into).collect(), agreeing })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// Weikert's tripod (CIRP Annals 53 (2004) 429): perpendicular probes, one over +x.
    fn nest() -> (NestCalibration, Matrix3<f64>) {
        let (flat, up) = ((2.0_f64 / 3.0).sqrt(), (1.0_f64 / 3.0).sqrt());
        let row = |turn_deg: f64| {
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            Vector3::new(flat * cos, flat * sin, up).transpose()
        };
        let probes_from_nest = Matrix3::from_rows(&[row(0.0), row(120.0), row(240.0)]);
        let nest_from_probes = probes_from_nest.transpose();
        (NestCalibration { nest_from_probes, zero_mm: Vector3::zeros() }, probes_from_nest)
    }

    fn jogs(letters: &[usize], standing: Standing) -> Vec<NestStep> {
        let (_, probes_from_nest) = nest();
        let jog = |&axis: &usize| {
            let ball_in_nest_mm = Vector3::ith(axis, 0.1);
            let probes_mm = standing.expects_mm(&(probes_from_nest * ball_in_nest_mm)) * 1.02;
            NestStep { ball_in_nest_mm, probes_mm: probes_mm.into() }
        };
        letters.iter().map(jog).collect()
    }

    #[test]
    fn a_good_nest_agrees_and_one_jog_leaves_an_exchange_open() {
        let found = judge_jogs(&nest().0, &jogs(&[0], Standing::AS_NEST)).unwrap();
        assert_eq!(found.agreeing, [Standing::AS_NEST, Standing { order: [0, 2, 1], ..Standing::AS_NEST }]);
        assert!((found.expected_mm[0][0] - 0.1 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_turned_probe_and_exchanged_probes_are_found() {
        let check = |standing: Standing, letters: &[usize]| {
            let found = judge_jogs(&nest().0, &jogs(letters, standing)).unwrap();
            assert_eq!(found.agreeing, [standing], "{letters:?}");
        };
        check(Standing { turned: [false, true, false], ..Standing::AS_NEST }, &[0, 1]);
        check(Standing::AS_NEST, &[0, 1]);
        check(Standing { order: [1, 0, 2], ..Standing::AS_NEST }, &[0, 1]);
        check(Standing { order: [0, 2, 1], ..Standing::AS_NEST }, &[0, 1]);
    }

    #[test]
    fn a_jog_that_two_answers_explain_gives_both_and_one_that_none_does_none() {
        // Along X the first probe alone against the two others: both of these may have its place.
        let standing = Standing { order: [1, 0, 2], ..Standing::AS_NEST };
        let found = judge_jogs(&nest().0, &jogs(&[0], standing)).unwrap();
        assert!(found.agreeing.contains(&standing) && found.agreeing.len() > 1, "{found:?}");
        let mut still = jogs(&[0], Standing::AS_NEST);
        still[0].probes_mm = [0.0; 3];
        assert!(judge_jogs(&nest().0, &still).unwrap().agreeing.is_empty());
    }
}
