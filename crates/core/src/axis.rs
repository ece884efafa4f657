//! Names of joints, and one value for each joint of a machine.
//!
//! A joint is known by its name: X Y Z U V W (linear) and A B C (rotary) of ISO 841, or any other name, whose kind the
//! machine file says. Each joint of a machine has a *slot*, its place in [`AxisValues`]; two machines may use one slot
//! for joints of different names. The nine letters have slots of their own, so that what works on letters asks no machine
//! (docs/decisions/0011-joints-by-name.md).

use std::fmt;
use std::ops::{Index, IndexMut};
use std::sync::OnceLock;

/// Places for the joints of one machine: X Y Z A B C U V W, and four more for rotary joints.
pub const SLOTS: usize = 13;

/// Names other than letters that one process can know.
const MOST_NAMES: usize = 200;

/// Longest name of a joint, so that columns and symbols stay readable.
const LONGEST_NAME: usize = 16;

/// The letters of ISO 841 in the order of their slots, upper and lower case.
const LETTERS: [[&str; 2]; 9] = [
    ["X", "x"],
    ["Y", "y"],
    ["Z", "z"],
    ["A", "a"],
    ["B", "b"],
    ["C", "c"],
    ["U", "u"],
    ["V", "v"],
    ["W", "w"],
];

/// What a joint cannot be called: names of expressions and of columns that mean something else.
const RESERVED: [&str; 16] = [
    "t",
    "pi",
    "sin",
    "cos",
    "tan",
    "abs",
    "sqrt",
    "exp",
    "log",
    "min",
    "max",
    "sign",
    "step",
    "setup",
    "target",
    "direction",
];

/// Names other than letters, as written and in lower case; filled from the front and never changed.
static NAMES: [OnceLock<[&'static str; 2]>; MOST_NAMES] = [const { OnceLock::new() }; MOST_NAMES];

/// The name of a joint (of a machine axis) with its place.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Joint {
    slot: Slot,
    /// Index in `LETTERS`, then in `NAMES`.
    name: u8,
}

/// The place of a joint in [`AxisValues`]; says whether a joint there is linear or rotary, not what it is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Slot(u8);

/// Why joints cannot be those of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JointError {
    /// Not a name for a joint.
    Name(String),
    /// More joints of one kind than a machine can have.
    TooMany {
        /// Rotary, or linear.
        rotary: bool,
    },
    /// The names of all machines read so far are too many.
    TooManyNames,
}

/// The letters of ISO 841 under their own names, for equations.
#[expect(missing_docs, reason = "the letters are documented where they are defined")]
pub mod iso {
    use super::Joint;

    pub const X: Joint = Joint::X;
    pub const Y: Joint = Joint::Y;
    pub const Z: Joint = Joint::Z;
    pub const A: Joint = Joint::A;
    pub const B: Joint = Joint::B;
    pub const C: Joint = Joint::C;
    pub const U: Joint = Joint::U;
    pub const V: Joint = Joint::V;
    pub const W: Joint = Joint::W;
}

impl Slot {
    /// All places.
    pub const ALL: [Self; SLOTS] = {
        let mut all = [Self(0); SLOTS];
        let mut k = 0;
        while k < SLOTS {
            all[k] = Self(k as u8);
            k += 1;
        }
        all
    };

    /// True where the joint is rotary.
    pub const fn is_rotary(self) -> bool {
        matches!(self.0, 3..=5 | 9..)
    }

    /// Index in [`AxisValues`].
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl Joint {
    /// Linear along X.
    pub const X: Self = Self::letter(0);
    /// Linear along Y.
    pub const Y: Self = Self::letter(1);
    /// Linear along Z.
    pub const Z: Self = Self::letter(2);
    /// Rotary about X.
    pub const A: Self = Self::letter(3);
    /// Rotary about Y.
    pub const B: Self = Self::letter(4);
    /// Rotary about Z.
    pub const C: Self = Self::letter(5);
    /// Second linear axis along X.
    pub const U: Self = Self::letter(6);
    /// Second linear axis along Y.
    pub const V: Self = Self::letter(7);
    /// Second linear axis along Z.
    pub const W: Self = Self::letter(8);

    /// The coordinates of a machine and the axes named after them; also the six components of a twist, in its order.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];
    /// X, Y and Z.
    pub const LINEAR: [Self; 3] = [Self::X, Self::Y, Self::Z];
    /// A, B and C.
    pub const ROTARY: [Self; 3] = [Self::A, Self::B, Self::C];
    /// Every letter of ISO 841, in the order of the slots.
    pub const ISO: [Self; 9] =
        [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C, Self::U, Self::V, Self::W];

    const fn letter(k: u8) -> Self {
        Self { slot: Slot(k), name: k }
    }

    /// The letter of ISO 841 named by `text` in upper or lower case. Joints of other names are known to their machine.
    pub fn parse(text: &str) -> Option<Self> {
        Self::ISO.into_iter().find(|letter| letter.as_str().eq_ignore_ascii_case(text))
    }

    /// The joints of one machine, given by name and whether they are rotary: letters take their own slots, the others the
    /// first that are free for their kind, in this order.
    ///
    /// # Errors
    /// A name that a joint cannot have, or more joints of a kind than there are slots.
    pub fn chain(joints: &[(&str, bool)]) -> Result<Vec<Self>, JointError> {
        let letters: Vec<Option<Self>> = joints
            .iter()
            .map(|(name, rotary)| Self::parse(name).filter(|l| l.is_rotary() == *rotary))
            .collect();
        let mut free: Vec<Slot> =
            Slot::ALL.into_iter().filter(|&slot| letters.iter().flatten().all(|l| l.slot != slot)).collect();
        let mut chain = Vec::new();
        for ((name, rotary), letter) in joints.iter().zip(letters) {
            chain.push(match letter {
                Some(letter) => letter,
                None => {
                    let name = interned(name)?;
                    let at = free.iter().position(|slot| slot.is_rotary() == *rotary);
                    let slot = free.remove(at.ok_or(JointError::TooMany { rotary: *rotary })?);
                    Self { slot, name }
                }
            });
        }
        Ok(chain)
    }

    /// The name as the machine file writes it; a letter in upper case.
    pub fn as_str(self) -> &'static str {
        self.names()[0]
    }

    /// The name in lower case, as used in the column names of points files.
    pub fn lower(self) -> &'static str {
        self.names()[1]
    }

    fn names(self) -> [&'static str; 2] {
        let k = usize::from(self.name);
        match LETTERS.get(k) {
            Some(names) => *names,
            None => NAMES[k - LETTERS.len()].get().copied().unwrap_or_default(),
        }
    }

    /// True for a rotary joint.
    pub const fn is_rotary(self) -> bool {
        self.slot.is_rotary()
    }

    /// Its place among the joints of its machine.
    pub const fn slot(self) -> Slot {
        self.slot
    }

    /// Index of its slot: 0…5 for X Y Z A B C.
    pub const fn index(self) -> usize {
        self.slot.index()
    }
}

/// Index of a name that is no letter (or a letter used for another kind of joint).
fn interned(name: &str) -> Result<u8, JointError> {
    let plain = |c: char| c.is_ascii_alphanumeric();
    let word = name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(plain);
    if !word || name.len() > LONGEST_NAME || RESERVED.contains(&name.to_ascii_lowercase().as_str()) {
        return Err(JointError::Name(name.into()));
    }
    // Kept for the life of the process, at most `MOST_NAMES` of them.
    let kept =
        || -> [&'static str; 2] { [Box::leak(name.into()), Box::leak(name.to_ascii_lowercase().into())] };
    let known = NAMES.iter().position(|names| names.get_or_init(kept)[0] == name);
    let at = known.ok_or(JointError::TooManyNames)?;
    u8::try_from(LETTERS.len() + at).map_err(|_| JointError::TooManyNames)
}

impl fmt::Display for Joint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Joint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Display for JointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of_kind = |rotary| Slot::ALL.iter().filter(|slot| slot.is_rotary() == rotary).count();
        match self {
            Self::Name(name) => write!(
                f,
                "\"{name}\" is not a name for a joint: a letter, then at most {} letters and digits, none of {}",
                LONGEST_NAME - 1,
                RESERVED.join(", ")
            ),
            Self::TooMany { rotary: true } => {
                write!(f, "a machine has at most {} rotary joints", of_kind(true))
            }
            Self::TooMany { rotary: false } => {
                write!(f, "a machine has at most {} linear joints", of_kind(false))
            }
            Self::TooManyNames => {
                write!(f, "machines read so far name {MOST_NAMES} joints, the most one process keeps")
            }
        }
    }
}

impl std::error::Error for JointError {}

/// One value for each slot; joints a machine does not have keep the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisValues<T>(pub [T; SLOTS]);

impl<T> AxisValues<T> {
    /// The value of each slot.
    pub fn from_fn(value: impl FnMut(Slot) -> T) -> Self {
        Self(Slot::ALL.map(value))
    }

    /// Slots and values.
    pub fn iter(&self) -> impl Iterator<Item = (Slot, &T)> {
        Slot::ALL.into_iter().zip(&self.0)
    }

    /// The value of each joint in `joints`, the default elsewhere.
    pub fn of(joints: impl IntoIterator<Item = Joint>, mut value: impl FnMut(Joint) -> T) -> Self
    where
        T: Default,
    {
        let mut values = Self::from_fn(|_| T::default());
        for joint in joints {
            values[joint] = value(joint);
        }
        values
    }
}

impl<T> Index<Joint> for AxisValues<T> {
    type Output = T;
    fn index(&self, letter: Joint) -> &T {
        &self.0[letter.index()]
    }
}

impl<T> IndexMut<Joint> for AxisValues<T> {
    fn index_mut(&mut self, letter: Joint) -> &mut T {
        &mut self.0[letter.index()]
    }
}

impl<T> Index<Slot> for AxisValues<T> {
    type Output = T;
    fn index(&self, slot: Slot) -> &T {
        &self.0[slot.index()]
    }
}

impl<T> IndexMut<Slot> for AxisValues<T> {
    fn index_mut(&mut self, slot: Slot) -> &mut T {
        &mut self.0[slot.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_keep_their_slots_whatever_else_a_machine_has() {
        let chain =
            Joint::chain(&[("j1", true), ("x", false), ("B", true), ("S", true), ("track", false)]).unwrap();
        assert_eq!((chain[1], chain[2]), (Joint::X, Joint::B));
        let slots: std::collections::HashSet<Slot> = chain.iter().map(|joint| joint.slot()).collect();
        assert_eq!(slots.len(), chain.len(), "{chain:?}");
        let kinds: Vec<bool> = chain.iter().map(|joint| joint.is_rotary()).collect();
        assert_eq!(kinds, [true, false, true, true, false]);
    }

    #[test]
    fn the_same_machine_read_twice_has_the_same_joints() {
        let robot = ["j1", "j2", "j3", "j4", "j5", "j6", "J7"].map(|name| (name, true));
        let [once, again] = [Joint::chain(&robot).unwrap(), Joint::chain(&robot).unwrap()];
        assert_eq!(once, again);
        assert_eq!((once[6].as_str(), once[6].lower()), ("J7", "j7"));
    }

    #[test]
    fn names_and_joints_beyond_the_limits_are_refused() {
        for name in ["1j", "", "j 1", "t", "Sin", "joint_of_the_wrist", "abcdefghijklmnopq"] {
            let error = Joint::chain(&[(name, true)]).unwrap_err();
            assert_eq!(error, JointError::Name(name.into()));
        }
        let rotary = ["j1", "j2", "j3", "j4", "j5", "j6", "j7", "j8"].map(|name| (name, true));
        let error = Joint::chain(&rotary).unwrap_err();
        assert_eq!(error.to_string(), "a machine has at most 7 rotary joints");
    }
}
