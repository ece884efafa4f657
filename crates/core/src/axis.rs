//! The six axis letters of ISO 841 and one value for each of them.

use std::fmt;
use std::ops::{Index, IndexMut};

/// The name of a machine axis: X, Y, Z linear; A, B, C rotary about X, Y, Z (ISO 841).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the letters are their own documentation")]
pub enum AxisLetter {
    X,
    Y,
    Z,
    A,
    B,
    C,
}

impl AxisLetter {
    /// All letters, in the order of the `AxisValues` array.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];
    /// The linear axes.
    pub const LINEAR: [Self; 3] = [Self::X, Self::Y, Self::Z];
    /// The rotary axes.
    pub const ROTARY: [Self; 3] = [Self::A, Self::B, Self::C];

    /// The letter named by `text` in upper or lower case.
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|letter| letter.as_str().eq_ignore_ascii_case(text))
    }

    /// Upper-case letter.
    pub const fn as_str(self) -> &'static str {
        ["X", "Y", "Z", "A", "B", "C"][self as usize]
    }

    /// Lower-case letter, as used in the column names of points files.
    pub const fn lower(self) -> &'static str {
        ["x", "y", "z", "a", "b", "c"][self as usize]
    }

    /// True for A, B and C.
    pub const fn is_rotary(self) -> bool {
        self as usize >= 3
    }
}

impl fmt::Display for AxisLetter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// One value for each axis letter; axes a machine does not have keep the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisValues<T>(pub [T; 6]);

impl<T> AxisValues<T> {
    /// The value of each axis computed from its letter.
    pub fn from_fn(mut value: impl FnMut(AxisLetter) -> T) -> Self {
        Self(AxisLetter::ALL.map(&mut value))
    }

    /// Letters and values in the order X Y Z A B C.
    pub fn iter(&self) -> impl Iterator<Item = (AxisLetter, &T)> {
        AxisLetter::ALL.into_iter().zip(&self.0)
    }
}

impl<T> Index<AxisLetter> for AxisValues<T> {
    type Output = T;
    fn index(&self, letter: AxisLetter) -> &T {
        &self.0[letter as usize]
    }
}

impl<T> IndexMut<AxisLetter> for AxisValues<T> {
    fn index_mut(&mut self, letter: AxisLetter) -> &mut T {
        &mut self.0[letter as usize]
    }
}
