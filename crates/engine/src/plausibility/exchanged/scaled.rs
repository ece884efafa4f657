//! Readings of one probe, or of one setup, in another unit than the others.
//!
//! Dividing readings makes whatever is left of them small, right or wrong. So the smaller ones are multiplied, by which a false trial leaves
//! more, not less; what that leaves is divided, as a right one, only where it would be believed undivided.

use super::axes::PROBES;
use super::{BELIEVED, Trial};
use crate::plausibility::fitted::Tried;

/// What readings are too small by, and what makes them so; then what makes them too large by it.
const FACTORS: [(f64, &str, &str); 3] = [
    (1000.0, "given in mm, not in µm?", "given in nm, not in µm?"),
    (25.4, "given in thousandths of an inch, not in µm?", "converted from inches twice?"),
    (10.0, "a decimal point, a gain of the amplifier?", "tenths of a µm, a gain of the amplifier?"),
];

impl Trial<'_> {
    /// Of every probe.
    pub(super) fn probes_scaled(&self) -> Vec<Tried> {
        let of_probe = |(probe, name): (usize, &&str)| {
            self.scaled(&format!("the readings {name}"), ["", ""], |_, channel| channel == probe)
        };
        PROBES.iter().enumerate().flat_map(of_probe).collect()
    }

    /// Of one setup, or of all the others the other way: only their ratio is seen.
    pub(super) fn setup_scaled(&self, setup: usize) -> Vec<Tried> {
        let (points, setups) = (&self.experiment.points, &self.run.setups);
        let alone = format!(" (setup {} alone)", setups[setup].name);
        let others: Vec<&str> =
            (0..setups.len()).filter(|&k| k != setup).map(|k| setups[k].name.as_str()).collect();
        let others = format!("those of setup {}", others.join(" and "));
        self.scaled("the readings", [&alone, &others], |at, _| points[at].state.setup == setup)
    }

    /// `is_one`: whether a channel of a point belongs to those in the other unit. `alone` follows its words; `others` may be those in the other
    /// unit instead, where they have a name.
    fn scaled(
        &self,
        which: &str,
        [alone, others]: [&str; 2],
        is_one: impl Fn(usize, usize) -> bool,
    ) -> Vec<Tried> {
        let multiplied = |factor: f64, of_those: bool| {
            self.left_mm(|readings| {
                for (at, reading) in readings.iter_mut().enumerate() {
                    let chosen = |channel: &usize| is_one(at, *channel) == of_those;
                    (0..3).filter(chosen).for_each(|channel| reading[channel] *= factor);
                }
            })
        };
        let before_mm = self.left_mm(|_| ());
        let both = |(factor, small, large): &(f64, &str, &str)| {
            let of_others_mm = multiplied(*factor, false);
            let is_right = BELIEVED * of_others_mm < before_mm;
            let instead = |way: &str, why: &str| match others {
                "" => String::new(),
                others => format!(", or {others} {way} by {factor} ({why})"),
            };
            let of = |way: &str, why: &str, rest: String| {
                format!("{which} {way} by {factor} ({why}){alone}{rest}")
            };
            let divided = (of("divided", large, instead("multiplied", small)), of_others_mm / factor);
            let small = of("multiplied", small, instead("divided", large));
            std::iter::once((small, multiplied(*factor, true)))
                .chain(is_right.then_some(divided))
                .collect::<Vec<_>>()
        };
        FACTORS.iter().flat_map(both).collect()
    }
}
