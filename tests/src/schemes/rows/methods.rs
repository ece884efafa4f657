//! Named methods of the literature: of each the numbers that have an uncertainty and an injected value.

use super::row::{LOCATIONS, OF_B, OF_C, PLAIN, Row};
use std::f64::consts::TAU;

/// EX0C + EX0B, EA0C + EA0B and EB0B of the truths of a table B-C.
const C_WITH_B: &[(&str, f64)] = &[("EX0C", -4.0), ("EY0C", 9.0), ("EA0C", 65.0), ("EB0C", -30.0)];

/// Location errors of C and the ranges of its error motions.
const OF_C_AND_MOTIONS: &[&str] =
    &["EX0C", "EY0C", "EA0C", "EB0C", "EXC range", "EYC range", "EZC range", "EAC range", "EBC range"];
const RANGES: &[&str] = OF_C_AND_MOTIONS.split_at(OF_C.len()).1;
/// The same by the truth `table-bc-motions`: a wave of amplitude A ranges over 2 A.
const C_WITH_B_AND_MOTIONS: &[(&str, f64)] = &[
    ("EX0C", -4.0),
    ("EY0C", 9.0),
    ("EA0C", 65.0),
    ("EB0C", -30.0),
    ("EXC range", 4.0),
    ("EYC range", 2.0),
    ("EZC range", 2.0),
    ("EAC range", 40.0),
    ("EBC range", 20.0),
];

/// The amplitudes of `table-bc-motions` as `rotary-values` names them.
const WAVES: [(&str, f64); 10] = [
    ("Radial along X, setup low, forward, 3 a turn", 2.0),
    ("Radial along X, setup low, back, 3 a turn", 2.0),
    ("Radial along Y, setup low, forward, 3 a turn", 1.0),
    ("Radial along Y, setup low, back, 3 a turn", 1.0),
    ("Axial along Z, setup low, forward, 2 a turn", 1.0),
    ("Axial along Z, setup low, back, 2 a turn", 1.0),
    ("Tilt EAC, forward, 2 a turn", 20.0),
    ("Tilt EAC, back, 2 a turn", 20.0),
    ("Tilt EBC, forward, 2 a turn", 10.0),
    ("Tilt EBC, back, 2 a turn", 10.0),
];
const WAVE_NAMES: [&str; 10] = {
    let mut names = [""; 10];
    let mut k = 0;
    while k < 10 {
        names[k] = WAVES[k].0;
        k += 1;
    }
    names
};

const TWO_HEIGHTS: Row = Row {
    source: "S0 eq. 1–3",
    truth: "table-bc-motions",
    method: Some("two-height"),
    identifies: OF_C_AND_MOTIONS,
    sizes: RANGES,
    also: C_WITH_B_AND_MOTIONS,
    cannot: "positioning error of C; error motions once a turn; errors of B by themselves",
    ..PLAIN
};

pub const ROWS: &[Row] = &[
    Row { scheme: "Two heights, C on the fly (method two-height)", cycle: "two-height-c", ..TWO_HEIGHTS },
    Row { scheme: "Two heights, C at rest (method two-height)", cycle: "two-height-c-static", ..TWO_HEIGHTS },
    Row {
        scheme: "Two places along B, on the fly (method two-height)",
        source: "S0 eq. 1–3",
        cycle: "two-height-b",
        truth: "table-bc",
        method: Some("two-height"),
        identifies: OF_B,
        cannot: "positioning error of B; errors of C",
        ..PLAIN
    },
    Row {
        scheme: "Error map of both axes, R-test on a grid (method error-map)",
        source: "S1 eq. 10–22",
        cycle: "r-test-static",
        truth: "table-bc",
        method: Some("error-map"),
        identifies: LOCATIONS,
        cannot: "as the R-test; positioning error of C",
        ..PLAIN
    },
    Row {
        scheme: "Error motions of C, three turns each way (method rotary-values)",
        source: "ISO 230-7",
        cycle: "rotary-values-c",
        truth: "table-bc-motions",
        method: Some("rotary-values"),
        identifies: &WAVE_NAMES,
        sizes: &WAVE_NAMES,
        also: &WAVES,
        cannot: "total, synchronous and asynchronous values have no u; error motions once a turn",
        ..PLAIN
    },
    Row {
        scheme: "Ball bar, C alone (method ball-bar)",
        source: "S4 eq. 1–3",
        cycle: "s4-c",
        truth: "table-bc-y",
        method: Some("ball-bar"),
        identifies: OF_C,
        also: C_WITH_B,
        cannot: "as the same bar by the joint fit",
        ..PLAIN
    },
    Row {
        scheme: "Ball bar, B alone (method ball-bar)",
        source: "S4 eq. 5–7",
        cycle: "s4-b",
        truth: "table-bc-y",
        method: Some("ball-bar"),
        identifies: OF_B,
        cannot: "as the same bar by the joint fit",
        ..PLAIN
    },
    Row {
        scheme: "Circle in XY, ball bar, errors of drives (method circular)",
        source: "ISO 230-4",
        cycle: "circle-xy",
        truth: "three-axis-circles",
        method: Some("circular"),
        identifies: OF_CIRCLE,
        also: DRIVES,
        cannot: "the mean scale against the length of the bar; EB0Z, EA0Z",
        ..PLAIN
    },
    Row {
        scheme: "Circle of 1 mm in XY, grid plate, errors of drives (method circular)",
        source: "ISO 230-4; S2 §3.1",
        cycle: "cross-grid-small",
        truth: "three-axis-drives",
        method: Some("circular"),
        identifies: &["XY EC0Y", "XY scale X−Y", "XY backlash X", "XY backlash Y", "XY servo X−Y"],
        also: &[("XY backlash X", -4.0), ("XY backlash Y", 2.0), ("XY servo X−Y", -2.0)],
        cannot: "EB0Z, EA0Z; squareness and scales to some 100 µrad and 100 µm/m only",
        ..PLAIN
    },
    Row {
        scheme: "Laser along X, five approaches from each side (method positioning)",
        source: "ISO 230-2",
        cycle: "linear-x",
        truth: "three-axis-circles",
        method: Some("positioning"),
        identifies: &["X mean reversal", "X M", "X E", "X E↑", "X E↓"],
        sizes: &["X M", "X E", "X E↑", "X E↓"],
        // Scale of 20 µm/m over 363 mm, and 4 µm of backlash.
        also: &[("X mean reversal", -4.0), ("X M", 7.26), ("X E", 11.26), ("X E↑", 7.26), ("X E↓", 7.26)],
        cannot: "zero of the display; A, R, B hold the scatter of the readings and have no injected value",
        ..PLAIN
    },
    Row {
        scheme: "R-test again and again while the machine warms up (method thermal)",
        source: "ISO 230-3",
        cycle: "r-test-warm-up",
        truth: "table-bc-warm",
        method: Some("thermal"),
        identifies: &[
            "EX0B change",
            "EX0B time constant",
            "EZ0B change",
            "EA0B change",
            "EB0B change",
            "EC0B change",
            "EX0C change",
            "EY0C change",
            "EA0C change",
        ],
        // The line of B goes the other way than the tool side.
        also: &[("EX0B change", -20.0)],
        cannot: "which of tool side and table grows",
        ..PLAIN
    },
    Row {
        scheme: "C at three feeds, parts with the feed (method quasi-static)",
        source: "Andolfatto 2011",
        cycle: "r-test-feeds-c",
        truth: "table-bc-feeds",
        method: Some("quasi-static"),
        identifies: &[
            "EX0C quasi-static part",
            "EY0C quasi-static part",
            "EA0C quasi-static part",
            "EB0C quasi-static part",
            "EX0C part with speed",
            "EY0C part with speed",
            "EA0C part with speed",
            "EB0C part with speed",
            "ball-setting.low.y part with speed",
        ],
        // 20 µs on a radius of 150 mm at 7200 °/min, a third of a turn a second.
        also: &[
            ("EX0C quasi-static part", 8.0),
            ("EY0C quasi-static part", -5.0),
            ("EA0C quasi-static part", -16.0),
            ("EB0C quasi-static part", 19.0),
            ("ball-setting.low.y part with speed", -150e3 * 20e-6 * TAU / 3.0),
        ],
        cannot: "quasi-static part of a setting (it is the mounting)",
        ..PLAIN
    },
];

/// What a circle in XY shows of squareness, scales, backlash, servo drives and reversals.
const OF_CIRCLE: &[&str] =
    &["XY EC0Y", "XY scale X−Y", "XY backlash X", "XY backlash Y", "XY servo X−Y", "XY reversal spike Y"];
/// The truth `three-axis-circles`.
const DRIVES: &[(&str, f64)] = &[
    ("XY EC0Y", 30.0),
    ("XY scale X−Y", 20.0),
    ("XY backlash X", -4.0),
    ("XY servo X−Y", -0.3),
    ("XY reversal spike Y", 6.0),
];
