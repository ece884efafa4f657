//! Probes whose inputs or senses are exchanged, and a nest that is mounted turned by right angles.

/// Names of the probes.
pub(super) const PROBES: [&str; 3] = ["dx", "dy", "dz"];

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
