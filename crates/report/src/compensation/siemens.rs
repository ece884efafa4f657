//! SINUMERIK 840D sl: machine data of the generic 5-axis transformation, sag compensation, encoder compensation.
//!
//! An NC program that adds to the vectors in the machine data, and replaces compensation tables: a program cannot know what a table of the builder holds between its own points. Rotary axes: offset vectors I1 … I4
//! and axis vectors V1, V2 by the table that relates tool carrier and transformation types 24, 40, 56 [SINUMERIK IM9 p. 572]. A
//! table of encoder compensation holds the error of an axis along itself: a positive value moves the axis in negative direction
//! [SINUMERIK 808D p. 106]; the shift of the zero of a head's last axis is such a table, the same everywhere. I3 (type 24) and I2 (type 56) begin
//! at the tool, so the line of the spindle is in them. A table of sag compensation moves a linear axis over another one [SINUMERIK K3 §4.4.3].
//! Limits: a table over one axis holds no tilt, and no displacement in axes that another rotary axis turns.

use super::format::{Format, Signs, argument, header, number};
use super::lines::{Kind, Line, Zeros, added, kind, lines, without_lean, zero_of_last};
use super::taken::{Component, carrier, is_spindle, on_table, taken};
use nalgebra::Vector3;
use trunnion_core::convert::deg_from_rad;
use trunnion_results::{AxisErrors, AxisTable, Chain, ChainJoint, CorrectionValues};

/// Less is no shift of a zero, rad.
const NOTHING_RAD: f64 = 1e-12;
/// Rows of a table that is the same everywhere.
const ANYWHERE_DEG: [f64; 2] = [-360.0, 360.0];

pub(super) static FORMAT: Format = Format {
    name: "siemens",
    about: "NC program: adds to `$MC_TRAFO5_…`, replaces the tables `$AN_CEC` and `$AA_ENC_COMP`",
    readers: "SINUMERIK 840D sl with TRAORI (types 24, 40, 56)",
    source: "SINUMERIK Operate (IM9) Commissioning Manual 12/2017, 6FC5397-1DP40-6BA1, p. 572; Extended Functions 03/2013, 6FC5397-1BP40-3BA1, K3 §4.4; SINUMERIK 808D Function Manual 01/2017, p. 106",
    ending: "mpf",
    signs: Signs::OfTheControl,
    enter: &[
        "Archive the machine data and the compensation tables of the control first: undoing needs them.",
        "Look at MD32700 ENC_COMP_ENABLE and MD32710 CEC_ENABLE of the axes in the tables. Where one is on, a table of the builder acts, and the file would replace it: add its values (from the archive) to those of the file, point by point, before you run it.",
        "Reserve the tables: MD38000 MM_ENC_COMP_MAX_POINTS and MD18342 MM_CEC_MAX_POINTS at least as large as the rows; switch MD32700 and MD32710 off.",
        "Compare the names of the axes (X1, B1, …) with MD10000 and the number of the transformation (…_1) with yours.",
        "Run the program once, in AUTOMATIC, with the access right of machine data. It adds to the vectors ($MC_): a second run would add twice. It replaces the tables ($AA_, $AN_).",
        "Switch MD32700 and MD32710 of the axes in the tables on, reset the control, reference the axes. With a value other than zero at the reference point the axis moves by it then (SINUMERIK 808D, p. 106): keep clear.",
        "The vectors act under TRAORI only: measure again with a program of `nc-program --tcp`.",
    ],
    undo: &[
        "Read the archive back. Without old tables: or switch MD32700 and MD32710 off, and run the lines $MC_ with the signs \"+\" and \"-\" exchanged.",
    ],
    unconfirmed: &[
        "The sign of $AN_CEC: taken as that of $AA_ENC_COMP, whose sign is documented.",
        "The number of the vector between the rotary axes of type 40: the manual prints 24558 next to the name TRAFO5_JOINT_OFFSET_1; the name is used.",
        "Whether the axis vectors of a table point along or against the turning workpiece: the program follows the sign that stands in the control.",
        "A place for a lean of the tool across the last axis of a head: not found in a public manual; nothing is written for it.",
    ],
    takes,
    write,
};

fn takes(chain: &Chain, errors: &AxisErrors) -> AxisErrors {
    let kept = taken(errors, &|table, component| why_not(chain, table, component));
    without_lean(chain, kept, Zeros::Shifted)
}

fn why_not(chain: &Chain, table: &AxisTable, component: Component) -> Option<String> {
    match component {
        _ if kind(chain).is_none() => Some("the transformation has two rotary axes".into()),
        Component::Location(_) if table.rotary => None,
        Component::Table(_) if is_spindle(chain, &table.axis) => {
            Some("the control has no tables over the angle of the spindle".into())
        }
        Component::Location(_) => Some("the transformation takes the linear axes as they are".into()),
        Component::Table(k) => match (along_itself(chain, table), carrier(chain, &table.axis)) {
            (Some(own), _) if own == k => None,
            (_, _) if k >= 3 => Some("a table over one axis holds no tilt".into()),
            (_, Some(carrier)) => Some(format!("it moves in axes that {carrier} turns")),
            (_, None) => None,
        },
    }
}

/// Component, X … C, that is the error of the axis along itself.
fn along_itself(chain: &Chain, table: &AxisTable) -> Option<usize> {
    let along = Vector3::from(joint(chain, &table.axis)?.direction);
    (0..3).find(|&k| along[k].abs() > 1.0 - 1e-9).map(|k| if table.rotary { k + 3 } else { k })
}

fn joint<'a>(chain: &'a Chain, axis: &str) -> Option<&'a ChainJoint> {
    chain.table.iter().chain(&chain.tool).find(|joint| joint.axis == axis)
}

fn write(chain: &Chain, errors: &AxisErrors, _: CorrectionValues) -> String {
    let mut text = String::new();
    if let Some(kind) = kind(chain) {
        text += &vectors(kind, lines(chain, errors, Zeros::Shifted));
    }
    let mut cec = 0;
    for table in &tables(chain, errors) {
        let own = along_itself(chain, table);
        if let Some(k) = own {
            text += &encoder_table(chain, table, k);
        }
        for linear in chain.table.iter().chain(&chain.tool).filter(|joint| !joint.rotary) {
            let values = moved_along(chain, table, linear, own);
            if values.iter().any(|value| *value != 0.0) {
                text += &sag_table(cec, table, &linear.axis, &values);
                cec += 1;
            }
        }
    }
    let values = format!("{}; units: mm, vectors of length 1, tables mm and degrees", what_it_does(&text));
    let head: String = header(errors, &values).iter().map(|line| format!("; {line}\n")).collect();
    head + &text + "M30\n"
}

/// Which lines add to what stands in the control, and which replace it.
fn what_it_does(lines: &str) -> String {
    let vectors = "values of $MC_ are added to what stands in the machine data";
    let tables: Vec<&str> =
        ["$AA_ENC_COMP", "$AN_CEC"].into_iter().filter(|name| lines.contains(name)).collect();
    let tables = tables.join(" and ");
    let replaced = format!(
        "the tables {tables} replace those that stand in the control: where MD32700 or MD32710 was on, add the old values point by point first"
    );
    match (lines.contains("$MC_"), tables.is_empty()) {
        (_, true) => vectors.into(),
        (true, false) => format!("{vectors}; {replaced}"),
        (false, false) => replaced,
    }
}

/// The tables of the axes, with the shift of the zero of the last rotary axis before the tool as a constant error along itself.
fn tables(chain: &Chain, errors: &AxisErrors) -> Vec<AxisTable> {
    let mut tables = errors.axes.clone();
    if let Some((joint, angle_rad)) = zero_of_last(chain, errors)
        && angle_rad.abs() > NOTHING_RAD
    {
        let at = tables.iter().position(|table| table.axis == joint.axis).unwrap_or(tables.len());
        if at == tables.len() {
            tables.push(AxisTable { axis: joint.axis.clone(), rotary: true, ..AxisTable::default() });
        }
        let table = &mut tables[at];
        if table.positions.is_empty() {
            (table.positions, table.errors) = (ANYWHERE_DEG.to_vec(), vec![[0.0; 6]; ANYWHERE_DEG.len()]);
        }
        if let Some(own) = along_itself(chain, table) {
            table.errors.iter_mut().for_each(|row| row[own] += angle_rad);
        }
    }
    tables.retain(|table| !table.positions.is_empty());
    tables
}

/// The lines of the rotary axes as vectors of the transformation.
fn vectors(kind: Kind, [table, tool]: [Vec<Line<'_>>; 2]) -> String {
    let moved = |line: Option<&Line<'_>>| line.map_or(Vector3::zeros(), |line| line.moved_mm);
    let (first, second) = match kind {
        Kind::TwoTable => (table.first(), table.get(1)),
        Kind::TwoTool => (tool.first(), tool.get(1)),
        Kind::Mixed => (tool.first(), table.first()),
    };
    let (first_mm, second_mm) = (moved(first), moved(second));
    let offsets = match kind {
        Kind::TwoTable => vec![
            ("TRAFO5_BASE_TOOL_1", first_mm),
            ("TRAFO5_JOINT_OFFSET_1", second_mm - first_mm),
            ("TRAFO5_PART_OFFSET_1", -second_mm),
        ],
        Kind::TwoTool => vec![
            ("TRAFO5_BASE_TOOL_1", second_mm),
            ("TRAFO5_JOINT_OFFSET_1", first_mm - second_mm),
            ("TRAFO5_PART_OFFSET_1", -first_mm),
        ],
        Kind::Mixed => vec![
            ("TRAFO5_BASE_TOOL_1", first_mm),
            ("TRAFO5_JOINT_OFFSET_1", -first_mm),
            ("TRAFO5_JOINT_OFFSET_PART_1", second_mm),
            ("TRAFO5_PART_OFFSET_1", -second_mm),
        ],
    };
    let mut text = String::from("DEF REAL _SIGN\n");
    for (name, change_mm) in offsets {
        for k in 0..3 {
            if let Some(added) = added(change_mm[k]) {
                text += &format!("$MC_{name}[{k}]=$MC_{name}[{k}]{added}\n");
            }
        }
    }
    for (name, line) in [("TRAFO5_AXIS1_1", first), ("TRAFO5_AXIS2_1", second)] {
        let Some(line) = line.filter(|line| line.turned != Vector3::zeros()) else { continue };
        let direction = Vector3::from(line.joint.direction) * line.joint.sense;
        let main = direction.iamax();
        let against = if direction[main] > 0.0 { "<" } else { ">" };
        text += &format!("_SIGN=1\nIF $MC_{name}[{main}]{against}0\n_SIGN=-1\nENDIF\n");
        for k in 0..3 {
            if let Some(added) = added(line.turned[k] * line.joint.sense) {
                text +=
                    &format!("$MC_{name}[{k}]=$MC_{name}[{k}]+_SIGN*({})\n", added.trim_start_matches('+'));
            }
        }
    }
    text + "NEWCONF\n"
}

/// Error along the axis itself: a positive value moves the axis in negative direction.
fn encoder_table(chain: &Chain, table: &AxisTable, component: usize) -> String {
    let Some(joint) = joint(chain, &table.axis) else { return String::new() };
    if table.errors.iter().all(|row| row[component] == 0.0) {
        return String::new();
    }
    let towards = Vector3::from(joint.direction)[component % 3] * joint.sense;
    let axis = format!("{}1", table.axis);
    let mut text = String::new();
    for (n, row) in table.errors.iter().enumerate() {
        let value = row[component] * towards;
        let value = if joint.rotary { deg_from_rad(value) } else { value };
        text += &format!("$AA_ENC_COMP[0,{n},{axis}]={}\n", number(value));
    }
    let (step, first, last) = steps(table);
    text + &format!(
        "$AA_ENC_COMP_STEP[0,{axis}]={step}\n$AA_ENC_COMP_MIN[0,{axis}]={first}\n$AA_ENC_COMP_MAX[0,{axis}]={last}\n$AA_ENC_COMP_IS_MODULO[0,{axis}]={}\n",
        u8::from(table.whole_turn)
    )
}

/// Deviation of tool against table along a linear axis at the rows of a table, what the axis corrects by itself left out.
fn moved_along(chain: &Chain, table: &AxisTable, linear: &ChainJoint, own: Option<usize>) -> Vec<f64> {
    let side = |axis: &str| if on_table(chain, axis) { -1.0 } else { 1.0 };
    let along = Vector3::from(linear.direction) * (linear.sense * side(&linear.axis));
    let deviation = |row: &[f64; 6]| {
        let component = |k: usize| if own == Some(k) { 0.0 } else { row[k] * side(&table.axis) };
        along.dot(&Vector3::new(component(0), component(1), component(2)))
    };
    table.errors.iter().map(deviation).collect()
}

fn sag_table(t: usize, table: &AxisTable, output: &str, values: &[f64]) -> String {
    let mut text: String = values
        .iter()
        .enumerate()
        .map(|(n, value)| format!("$AN_CEC[{t},{n}]={}\n", number(*value)))
        .collect();
    let (step, first, last) = steps(table);
    text += &format!("$AN_CEC_INPUT_AXIS[{t}]=({}1)\n$AN_CEC_OUTPUT_AXIS[{t}]=({output}1)\n", table.axis);
    text += &format!("$AN_CEC_STEP[{t}]={step}\n$AN_CEC_MIN[{t}]={first}\n$AN_CEC_MAX[{t}]={last}\n");
    text + &format!(
        "$AN_CEC_DIRECTION[{t}]=0\n$AN_CEC_MULT_BY_TABLE[{t}]=0\n$AN_CEC_IS_MODULO[{t}]={}\n",
        u8::from(table.whole_turn)
    )
}

/// Step, first and last position of a table.
fn steps(table: &AxisTable) -> (String, String, String) {
    let (first, last) = (table.positions[0], table.positions[table.positions.len() - 1]);
    let step = (last - first) / (table.positions.len() - 1).max(1) as f64;
    (number(step), argument(first), argument(last))
}
