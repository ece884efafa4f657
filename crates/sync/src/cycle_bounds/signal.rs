//! The controller's signal: off, on, or a number that says which cycle.

/// As last known: a reading that does not know it changes nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    /// Each number is a cycle of its own; without it all but 0 is one and the same *on*.
    by_number: bool,
    number: Option<u32>,
}

impl Signal {
    pub(super) fn by_number(by_number: bool) -> Self {
        Self { by_number, number: None }
    }

    /// The number last known.
    pub(super) fn number(&self) -> Option<u32> {
        self.number
    }

    /// It says another cycle than before, with nothing between.
    pub(super) fn is_another(&self, now: Option<u32>) -> bool {
        self.by_number && self.number > Some(0) && now > Some(0) && now != self.number
    }

    /// It comes on, or says another cycle. What was never known before does not come on.
    pub(super) fn comes(&self, now: Option<u32>) -> bool {
        self.is_another(now) || self.number == Some(0) && now > Some(0)
    }

    pub(super) fn take(&mut self, now: Option<u32>) {
        self.number = now.or(self.number);
    }
}
