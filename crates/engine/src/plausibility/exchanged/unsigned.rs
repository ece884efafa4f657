//! Readings that lost their signs: a display or an export that gives absolute values.
//!
//! Each sign is guessed from the base model and the model is fitted to what they make, in turn, until no sign changes. Where some probe kept
//! its signs, the guess is what that probe says of the others; where none did, it is the direction of the model along which the squares of the
//! readings are largest: the spectral start and the alternating steps of recovering a signal from magnitudes [Netrapalli 2015, alg. 1
//! and 2].

use super::Trial;
use super::axes::PROBES;
use crate::plausibility::fitted::{Fitted, Tried, columns};
use nalgebra::DVector;

/// Rounds of guessing at most: each leaves less, so that they end.
const MOST_ROUNDS: usize = 30;

impl Trial<'_> {
    /// Of every probe that never reads less than zero, where there is one; in one setup, or all.
    pub(super) fn unsigned(&self, setup: Option<usize>) -> Option<Tried> {
        let readings_mm = self.experiment.readings_mm();
        let points = &self.experiment.points;
        let own = self.points_of(setup);
        let lost = [0, 1, 2].map(|probe| own.iter().all(|&at| points[at].reading_mm[probe] >= 0.0));
        let mut is_lost = vec![false; readings_mm.len()];
        for at in own {
            let own = self.experiment.rows_of(at).enumerate();
            own.for_each(|(probe, row)| is_lost[row] = lost[probe]);
        }
        let names: Vec<&str> = (0..3).filter(|&probe| lost[probe]).map(|probe| PROBES[probe]).collect();
        let mut guess_mm = match names.len() {
            0 => return None,
            3 if setup.is_none() => self.model.strongest(&readings_mm)?,
            _ => {
                let of_others = Fitted::on(&columns(self.experiment)?, |row| !is_lost[row]);
                &readings_mm - of_others.left_mm(&readings_mm)
            }
        };
        let signed = |guess_mm: &DVector<f64>| {
            DVector::from_fn(readings_mm.len(), |row, _| {
                if is_lost[row] { readings_mm[row].copysign(guess_mm[row]) } else { readings_mm[row] }
            })
        };
        let mut with_signs_mm = signed(&guess_mm);
        for _ in 0..MOST_ROUNDS {
            guess_mm = &with_signs_mm - self.model.left_mm(&with_signs_mm);
            let again_mm = signed(&guess_mm);
            if again_mm == with_signs_mm {
                break;
            }
            with_signs_mm = again_mm;
        }
        let words = format!("signs given to the readings {}: they are absolute values", names.join(", "));
        Some((words, self.model.rms_mm(&with_signs_mm)))
    }
}
