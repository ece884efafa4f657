//! Signs of the values.

/// Signs of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// Actual minus nominal, rotations right-handed (docs/design/physics.md §1).
    #[default]
    RightHanded,
    /// As the source of the method prints them.
    Source,
}

impl Convention {
    /// Every convention with its name on the command line.
    pub const NAMES: [(&'static str, Self); 2] =
        [("right-handed", Self::RightHanded), ("source", Self::Source)];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, convention)| *convention == self).expect("every convention is listed").0
    }
}
