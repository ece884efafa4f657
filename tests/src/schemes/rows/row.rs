//! What a row of the schemes says, and names that rows share.

/// One scheme.
pub struct Row {
    /// What is measured with what.
    pub scheme: &'static str,
    /// Where it is described.
    pub source: &'static str,
    /// File in `config/cycles`.
    pub cycle: &'static str,
    /// File in `config/truths`.
    pub truth: &'static str,
    /// File in `config/models`; the base model without one.
    pub model: Option<&'static str>,
    /// What must be among the numbers; of a named method, which gives further values, the numbers that are judged.
    pub identifies: &'static [&'static str],
    /// Those of them that have no sign: ranges and amplitudes.
    pub sizes: &'static [&'static str],
    /// Method of the literature by which it is judged; the joint fit without one.
    pub method: Option<&'static str>,
    /// In words for the table.
    pub cannot: &'static str,
    /// Amplitudes that the truth does not list by the name of the parameter.
    pub also: &'static [(&'static str, f64)],
}

/// Location errors of a table B-C.
pub const LOCATIONS: &[&str] = &["EX0B", "EZ0B", "EA0B", "EB0B", "EC0B", "EX0C", "EY0C", "EA0C"];
/// Those of B, and of C, as one axis alone shows them.
pub const OF_B: &[&str] = &["EX0B", "EZ0B", "EA0B", "EC0B"];
pub const OF_C: &[&str] = &["EX0C", "EY0C", "EA0C", "EB0C"];
/// Squarenesses.
pub const SQUARE: &[&str] = &["EC0Y", "EB0Z", "EA0Z"];
/// Squarenesses and scales.
pub const SQUARE_AND_SCALES: &[&str] =
    &["EC0Y", "EB0Z", "EA0Z", "linear-scale:X.scale", "linear-scale:Y.scale", "linear-scale:Z.scale"];

/// By the base model and the joint fit, with nothing that the truth does not list.
pub const PLAIN: Row = Row {
    scheme: "",
    source: "",
    cycle: "",
    truth: "",
    model: None,
    method: None,
    identifies: &[],
    sizes: &[],
    cannot: "",
    also: &[],
};
