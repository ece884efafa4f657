//! The number of a signal, which says which cycle begins.

/// Of a signal whose source gives a number: 0 is off, and what lies between two numbers or below zero is on without being one of them.
pub fn signal_of(number: f64) -> u32 {
    let is_whole = number.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&number);
    if is_whole { number as u32 } else { u32::from(number != 0.0) }
}
