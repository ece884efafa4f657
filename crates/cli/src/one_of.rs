//! A word of the command line that names one of a few things.

use trunnion_core::names::allowed;

/// The thing of this name.
///
/// # Errors
/// Another word, with those that are allowed.
pub fn one_of<T: Copy>(names: &[(&'static str, T)], text: &str) -> Result<T, String> {
    let named = names.iter().find(|(name, _)| *name == text);
    let refused = || format!("allowed: {}", allowed(text, names.iter().map(|(name, _)| *name)));
    named.map(|(_, thing)| *thing).ok_or_else(refused)
}
