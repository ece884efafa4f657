//! Schemes of linear axes.

use super::row::{PLAIN, Row, SQUARE, SQUARE_AND_SCALES};

/// What the truths `three-axis-volume` and `table-bc-volume` hold in addition to squarenesses, by the names of a volume: scales as displacement at the
/// end of the measured range (µm), bows P2 and S-shapes P3 of the guides (µm), turns of the carriages (µrad).
const fn volume(exx: f64, eyy: f64, ezz: f64) -> [(&'static str, f64); 24] {
    [
        ("EXX.P1", exx),
        ("EYY.P1", eyy),
        ("EZZ.P1", ezz),
        ("EYX.P2", 2.4),
        ("EYX.P3", -1.5),
        ("EZX.P2", 1.2),
        ("EZX.P3", 0.9),
        ("EZY.P2", -2.0),
        ("EZY.P3", 2.4),
        ("EXY.P2", 2.8),
        ("EXY.P3", -1.2),
        ("EXZ.P2", 1.5),
        ("EXZ.P3", -1.0),
        ("EYZ.P2", -2.0),
        ("EYZ.P3", 1.5),
        ("EAX.P1", 20.0),
        ("EBX.P1", -14.0),
        ("ECX.P1", 8.0),
        ("EAY.P1", -12.0),
        ("EBY.P1", 15.0),
        ("ECY.P1", 9.0),
        ("EAZ.P1", 9.0),
        ("EBZ.P1", -18.0),
        ("ECZ.P1", -5.4),
    ]
}

pub const ROWS: &[Row] = &[
    Row {
        scheme: "Circle in XY, ball bar",
        source: "ISO 230-4; S2 §3.1; S4",
        cycle: "circle-xy",
        truth: "three-axis-square",
        model: Some("straight-lines-xy"),
        identifies: &["EC0Y"],
        cannot: "the mean scale against the length of the bar; EB0Z, EA0Z",
        ..PLAIN
    },
    Row {
        scheme: "Circle in YZ, ball bar",
        source: "ISO 230-4; S4",
        cycle: "circle-yz",
        truth: "three-axis-square",
        model: Some("straight-lines-yz"),
        identifies: &["EA0Z"],
        cannot: "the mean scale against the length of the bar; EC0Y, EB0Z",
        ..PLAIN
    },
    Row {
        scheme: "Circle in ZX, ball bar",
        source: "ISO 230-4; S4",
        cycle: "circle-zx",
        truth: "three-axis-square",
        model: Some("straight-lines-zx"),
        identifies: &["EB0Z"],
        cannot: "the mean scale against the length of the bar; EC0Y, EA0Z",
        ..PLAIN
    },
    Row {
        scheme: "Four body diagonals, laser interferometer",
        source: "S2 §3.2, eq. 7",
        cycle: "diagonal",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE,
        cannot: "each scale (only their sum); tilt of the beam (second order)",
        ..PLAIN
    },
    Row {
        scheme: "Both diagonals of each face, laser interferometer",
        source: "ISO 230-6",
        cycle: "face-diagonal",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE_AND_SCALES,
        cannot: "straightness and angular errors one by one; tilt of the beam (second order)",
        ..PLAIN
    },
    Row {
        scheme: "Step diagonals, flat mirror",
        source: "S2 §3.2",
        cycle: "step-diagonal",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE,
        cannot: "each scale against the tilts of the mirrors (only their sum)",
        ..PLAIN
    },
    Row {
        scheme: "Ball plate in five placements",
        source: "S2 §3.3",
        cycle: "ball-plate",
        truth: "three-axis-volume",
        model: Some("volume"),
        identifies: &["EC0Y", "EB0Z", "EA0Z", "EXX.P1", "EYY.P1", "EZZ.P1", "EAX.P1", "EBX.P1", "ECX.P1"],
        cannot: "angular errors of Z and the roll of Y with one length of tool",
        also: &volume(2.4, -1.6, 1.92),
        ..PLAIN
    },
    Row {
        scheme: "The same plate uncalibrated: self-calibration",
        source: "S2 §3.3",
        cycle: "ball-plate-self",
        truth: "three-axis-square",
        model: Some("self-calibration"),
        identifies: SQUARE,
        cannot: "each scale (the size of the plate is unknown; only their differences); form as far as it is a placement",
        ..PLAIN
    },
    Row {
        scheme: "Scale bar in nine placements, balls of unknown radius",
        source: "S2 §3.3",
        cycle: "scale-bar",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE_AND_SCALES,
        cannot: "straightness and angular errors one by one; how the bar lies",
        ..PLAIN
    },
    Row {
        scheme: "Passive serial link, two arms",
        source: "S2 §3.4",
        cycle: "passive-arm",
        truth: "table-bc-linear",
        model: Some("straight-lines-xy-bc"),
        identifies: &["EC0Y"],
        cannot: "each scale against the lengths of the arms (only their difference); Z",
        ..PLAIN
    },
    Row {
        scheme: "Passive parallel link, laser ball bar on three feet",
        source: "S2 §3.4",
        cycle: "laser-ball-bar",
        truth: "table-bc-linear",
        model: Some("straight-lines-bc"),
        identifies: SQUARE_AND_SCALES,
        cannot: "rotary axes (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "Tracking interferometer, four stations, two lengths of tool: 21 errors",
        source: "S2 §3.5, eq. 8",
        cycle: "tracker",
        truth: "table-bc-volume",
        model: Some("volume-bc"),
        identifies: &[
            "EC0Y", "EB0Z", "EA0Z", "EXX.P1", "EYY.P1", "EZZ.P1", "EYX.P2", "EZX.P2", "EAX.P1", "EBX.P1",
            "ECX.P1", "EXY.P2", "EZY.P2", "EAY.P1", "EBY.P1", "EXZ.P2", "EYZ.P2", "EAZ.P1", "EBZ.P1",
        ],
        cannot: "roll of Z and yaw of Y (no tool off the spindle line); rotary axes (stationary)",
        also: &volume(3.6, -2.4, 1.5),
        ..PLAIN
    },
    Row {
        scheme: "Multilateration by the same distances: error of each target, without a model",
        source: "S2 §3.5, eq. 8",
        cycle: "tracker",
        truth: "table-bc-volume",
        method: Some("multilateration"),
        identifies: &["ΔX", "ΔY", "ΔZ"],
        cannot: "a shift and a turn of the whole volume; turns of the tool; rotary axes (stationary)",
        ..PLAIN
    },
    Row {
        scheme: "Cross-grid encoder in XY, square of places at rest",
        source: "S2 §3.3",
        cycle: "cross-grid-xy",
        truth: "three-axis-plane",
        model: Some("plane-xy"),
        identifies: &["EC0Y", "EXX.P1", "EYY.P1", "EYX.P2", "EXY.P2", "ECX.P1"],
        cannot: "displacements along Z, turns of the head, so EB0Z, EA0Z, roll and pitch; rotary axes",
        also: &volume(1.2, -0.8, 0.96),
        ..PLAIN
    },
    Row {
        scheme: "Cross-grid encoder in YZ, square of places at rest",
        source: "S2 §3.3",
        cycle: "cross-grid-yz",
        truth: "three-axis-plane",
        model: Some("plane-yz"),
        identifies: &["EA0Z", "EYY.P1", "EZZ.P1", "EZY.P2", "EYZ.P2", "EAY.P1"],
        cannot: "displacements along X, turns of the head, so EC0Y, EB0Z; rotary axes",
        also: &volume(1.2, -0.8, 0.96),
        ..PLAIN
    },
    Row {
        scheme: "Cross-grid encoder in ZX, square of places at rest",
        source: "S2 §3.3",
        cycle: "cross-grid-zx",
        truth: "three-axis-plane",
        model: Some("plane-zx"),
        identifies: &["EB0Z", "EZZ.P1", "EXX.P1", "EXZ.P2", "EZX.P2", "EBX.P1"],
        cannot: "displacements along Y, turns of the head, so EC0Y, EA0Z; rotary axes",
        also: &volume(1.2, -0.8, 0.96),
        ..PLAIN
    },
    Row {
        scheme: "Circle in XY, cross-grid encoder",
        source: "ISO 230-4; S2 §3.1, §3.3",
        cycle: "cross-grid-circle-xy",
        truth: "three-axis-square",
        model: Some("straight-lines-xy"),
        identifies: &["EC0Y", "linear-scale:X.scale", "linear-scale:Y.scale"],
        cannot: "displacements along Z; EB0Z, EA0Z",
        ..PLAIN
    },
    Row {
        scheme: "Circle in YZ, cross-grid encoder",
        source: "ISO 230-4; S2 §3.1, §3.3",
        cycle: "cross-grid-circle-yz",
        truth: "three-axis-square",
        model: Some("straight-lines-yz"),
        identifies: &["EA0Z", "linear-scale:Y.scale", "linear-scale:Z.scale"],
        cannot: "displacements along X; EC0Y, EB0Z",
        ..PLAIN
    },
    Row {
        scheme: "Circle in ZX, cross-grid encoder",
        source: "ISO 230-4; S2 §3.1, §3.3",
        cycle: "cross-grid-circle-zx",
        truth: "three-axis-square",
        model: Some("straight-lines-zx"),
        identifies: &["EB0Z", "linear-scale:Z.scale", "linear-scale:X.scale"],
        cannot: "displacements along Y; EC0Y, EA0Z",
        ..PLAIN
    },
    Row {
        scheme: "Level in the spindle against one on the table, two directions",
        source: "ISO 230-1",
        cycle: "level",
        truth: "three-axis-angles",
        model: Some("volume"),
        identifies: &["EAX.P1", "EBX.P1", "EAY.P1", "EBY.P1", "EAZ.P1", "EBZ.P1"],
        cannot: "turns about the vertical (ECX, ECY, ECZ); all that shifts and does not turn",
        also: &[
            ("EAX.P1", 20.0),
            ("EBX.P1", -14.0),
            ("EAY.P1", -12.0),
            ("EBY.P1", 15.0),
            ("EAZ.P1", 9.0),
            ("EBZ.P1", -18.0),
        ],
        ..PLAIN
    },
];
