//! Schemes of rotary axes.

use super::row::{LOCATIONS, OF_B, OF_C, PLAIN, Row};

pub const ROWS: &[Row] = &[
    Row {
        scheme: "R-test, nest on the table, grid of poses",
        source: "S1",
        cycle: "r-test-static",
        truth: "table-bc",
        identifies: LOCATIONS,
        cannot: "EY0B against EY0C, EB0C against EB0B, EZ0C and EC0C against the setting",
        ..PLAIN
    },
    Row {
        scheme: "Sphere touched at indexed angles",
        source: "S2 §4.3",
        cycle: "touch-probe",
        truth: "table-bc",
        identifies: LOCATIONS,
        cannot: "as the R-test",
        ..PLAIN
    },
    Row {
        scheme: "Faces of a column touched at indexed angles",
        source: "S2 §4.3",
        cycle: "touch-probe-column",
        truth: "table-bc",
        identifies: LOCATIONS,
        cannot: "as the R-test; place and turn of the column contain EZ0C and EC0C",
        ..PLAIN
    },
    Row {
        scheme: "Square column machined at indexed angles",
        source: "S2 §4.5",
        cycle: "machined-column",
        truth: "table-bc",
        identifies: LOCATIONS,
        cannot: "as the R-test; place and turn of the workpiece contain EZ0C and EC0C",
        ..PLAIN
    },
    Row {
        scheme: "Ball bar, C alone under the bar (C-X, C-Y, C-Z)",
        source: "S4",
        cycle: "s4-c",
        truth: "table-bc-y",
        identifies: OF_C,
        cannot: "B (stationary); heights of the balls",
        ..PLAIN
    },
    Row {
        scheme: "Ball bar, B alone under the bar (B-X, B-Z, B-Y)",
        source: "S4",
        cycle: "s4-b",
        truth: "table-bc-y",
        identifies: OF_B,
        cannot: "C (stationary); EY0B against the setting",
        ..PLAIN
    },
    Row {
        scheme: "BK1: tilting axis with linear axes, three bar directions",
        source: "ISO 10791-6; S2 §4.1",
        cycle: "bk1-b",
        truth: "table-bc",
        identifies: OF_B,
        cannot: "C (stationary); length of the bar against the setting",
        ..PLAIN
    },
    Row {
        scheme: "BK2: turning axis with X and Y, three bar directions",
        source: "ISO 10791-6; S4 C-XY",
        cycle: "bk2-c",
        truth: "table-bc",
        identifies: OF_C,
        cannot: "B (stationary); length of the bar against the setting",
        ..PLAIN
    },
    Row {
        scheme: "BK1 on a table A-C",
        source: "ISO 10791-6",
        cycle: "bk1-a",
        truth: "table-ac",
        identifies: &["EY0A", "EZ0A", "EB0A", "EC0A"],
        cannot: "C (stationary); length of the bar against the setting",
        ..PLAIN
    },
    Row {
        scheme: "BK2 on a table A-C",
        source: "ISO 10791-6",
        cycle: "bk2-c-of-ac",
        truth: "table-ac",
        identifies: OF_C,
        cannot: "A (stationary); length of the bar against the setting",
        ..PLAIN
    },
    Row {
        scheme: "Head, tilting axis with linear axes",
        source: "ISO 10791-6",
        cycle: "head-b",
        truth: "head-bc",
        identifies: &["EA0B", "EC0B"],
        cannot: "EX0B, EZ0B against the setting of the ball; length of the bar; C (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "Head, turning axis with X and Y",
        source: "ISO 10791-6",
        cycle: "head-c",
        truth: "head-bc",
        identifies: &["EA0C", "EB0C"],
        cannot: "EX0C, EY0C against the length of the bar; B (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "R-test of a head with two axes, two lengths of tool",
        source: "ISO 10791-6; S2 §4.2",
        cycle: "r-test-head-bc",
        truth: "head-bc",
        identifies: &["EA0C", "EB0C", "EX0B", "EA0B"],
        cannot: "EX0C, EY0C, EZ0B against the setting of the ball",
        ..PLAIN
    },
    Row {
        scheme: "R-test of a head whose spindle is indexed",
        source: "S2 tables 2–3; S1 §3.2",
        cycle: "r-test-head-bc-spindle",
        truth: "head-bc-spindle",
        identifies: &["EA0C", "EB0C", "EX0B", "EA0B", "EX0C1", "EY0C1", "EA0C1", "EB0C1"],
        cannot: "EX0C, EY0C, EZ0B against the setting of the ball; EB0B (EB0C1 is the lean of the spindle at B = 0); zero angles of C and spindle",
        ..PLAIN
    },
    Row {
        scheme: "R-test of a table under a spindle that is indexed",
        source: "S2 tables 2–3; S1 §3.2",
        cycle: "r-test-table-bc-spindle",
        truth: "table-bc-spindle",
        identifies: &["EX0B", "EZ0B", "EA0B", "EC0B", "EX0C", "EA0C", "EA0C1", "EB0C1"],
        cannot: "EX0C1, EY0C1 (EX0B and EY0C are the distances between the lines); zero angles of C and spindle",
        ..PLAIN
    },
    Row {
        scheme: "R-test of one axis in the head and one under the workpiece",
        source: "ISO 10791-6; S2 §4.2",
        cycle: "r-test-head-a-table-c",
        truth: "head-a-table-c",
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C", "EB0A", "EC0A"],
        cannot: "EZ0A against the setting of the ball; EY0A (EY0C is the distance between the lines)",
        ..PLAIN
    },
    Row {
        scheme: "BK3: both rotary axes at constant speeds, three bar directions",
        source: "ISO 10791-6",
        cycle: "bk3-bc",
        truth: "table-bc",
        identifies: &["EA0B", "EB0B", "EC0B", "EX0C", "EA0C"],
        cannot: "EX0B, EZ0B, EY0C against the length of the bar and the settings; EB0B to some 8 µrad only",
        ..PLAIN
    },
    Row {
        scheme: "BK4: cone-frustum path, five axes at once",
        source: "NAS 979; ISO 10791-6; S4",
        cycle: "bk4-cone",
        truth: "table-bc",
        identifies: &["EX0B", "EX0C"],
        cannot: "most location errors one by one: a test of acceptance, not of diagnosis",
        ..PLAIN
    },
    Row {
        scheme: "Machined cone frustum, measured on two circles",
        source: "NAS 979; ISO 10791-7; S2 §4.5",
        cycle: "machined-cone",
        truth: "table-bc",
        identifies: &["EB0B", "EY0C"],
        cannot: "EX0B against EX0C and EA0B against EA0C (some 20 µm and 100 µrad), EZ0B; place of the part: a test of acceptance, not of diagnosis",
        ..PLAIN
    },
    Row {
        scheme: "R-test, both heights pass by pass, twice",
        source: "S1; ISO 230-3",
        cycle: "r-test-interleaved",
        truth: "table-bc",
        identifies: LOCATIONS,
        cannot: "as the R-test",
        ..PLAIN
    },
    Row {
        scheme: "R-test while C turns",
        source: "S2 §4.2",
        cycle: "r-test-sweep-c",
        truth: "table-bc",
        identifies: OF_C,
        cannot: "B (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "R-test while B turns",
        source: "S2 §4.2",
        cycle: "r-test-sweep-b",
        truth: "table-bc",
        identifies: OF_B,
        cannot: "C (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "R-test of a hybrid machine, three legs and two axes",
        source: "S3 §2",
        cycle: "hybrid-static",
        truth: "hybrid-exechon",
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C", "EY0A", "EZ0A", "EB0A"],
        cannot: "EZ0C and EC0A (the others of their directions hold them)",
        ..PLAIN
    },
];
