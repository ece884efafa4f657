//! Which mechanical causes S4 table 2 names for each kind of error, in words for a technician.

/// Kinds of errors that the ball bar shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ErrorKind {
    /// Mean tilt of an axis line: E_A0, E_B0, E_C0.
    Squareness,
    /// Mean place of an axis line.
    Place,
    /// Error motion across the axis.
    Radial,
    /// Error motion along the axis.
    Axial,
    /// Change of the tilt over the turn.
    Tilt,
    /// Difference between the directions of turning.
    Reversal,
    /// Several axes at once.
    Path,
}

/// Likely causes of each kind [S4 tables 1 and 2].
const CAUSES: [(ErrorKind, &str); 7] = [
    (
        ErrorKind::Squareness,
        "likely: assembly, the axis is not square or parallel to its neighbour (S4 table 1)",
    ),
    (
        ErrorKind::Place,
        "likely: assembly or an old zero offset, the axis line is not where the controller has it (S4 table 1)",
    ),
    (
        ErrorKind::Radial,
        "likely: bearings (run-out, ring profile, rollers of unlike size), gravity on the rotating unit (S4 table 2)",
    ),
    (
        ErrorKind::Axial,
        "likely: bearings (ring profile, rollers of unlike size), gravity on the rotating unit (S4 table 2)",
    ),
    (
        ErrorKind::Tilt,
        "likely: angular motion of the centre line in its bearings (ring profile, rollers), gravity bending the unit (S4 table 2)",
    ),
    (
        ErrorKind::Reversal,
        "likely: play or friction in bearings or drive, seen as a step with the direction (S4 §4.3)",
    ),
    (
        ErrorKind::Path,
        "several axes at once: location errors, positioning (encoder, worm pitch, compensation table), drives out of step, too \
         short blocks (S4 table 2, §4.4)",
    ),
];

/// Words for the likely causes.
pub(super) fn causes(kind: ErrorKind) -> &'static str {
    CAUSES.iter().find(|(of, _)| *of == kind).map_or("", |(_, words)| words)
}
