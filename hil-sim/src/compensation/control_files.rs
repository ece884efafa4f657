//! Reading what is written for controls: SINUMERIK and FANUC programs, rows and tables of HEIDENHAIN.
//!
//! The signs are those that the controls document, not those of the program that wrote the files: a positive value of a SINUMERIK
//! table moves the axis in negative direction; vectors point to the lines of the axes.

use super::control::{Control, Cross};
use super::numbers::{Found, Line, Numbers, number};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use trunnion_core::Joint;
use trunnion_machine::Machine;

/// Numbers by name and index, as a program leaves them.
type Registers = BTreeMap<(String, usize), f64>;

const ASSIGNMENT: &str = "NAME[INDEX]=NUMBER, or NAME[INDEX]=NAME[INDEX]+NUMBER";

/// A program of a SINUMERIK.
pub(super) fn siemens(machine: &Machine, lines: &[Line<'_>]) -> Result<Control, Found> {
    let mut vectors = Registers::new();
    let mut tables: BTreeMap<(bool, usize, String), Table> = BTreeMap::new();
    for &(line, text) in lines {
        let Some((left, right)) = text.split_once('=').filter(|_| text.starts_with('$')) else { continue };
        let (name, index) = indexed(left).ok_or((line, text.into(), ASSIGNMENT))?;
        if let Some(vector) = name.strip_prefix("$MC_") {
            let added = right.strip_prefix(left).ok_or((line, text.into(), ASSIGNMENT))?;
            // The simulated control holds vectors along the axes of the machine file: _SIGN is 1.
            let added = added.trim_start_matches("+_SIGN*").trim_matches(['(', ')']);
            let component = index[0].parse().map_err(|_| (line, text.into(), ASSIGNMENT))?;
            *vectors.entry((vector.into(), component)).or_default() += number(line, added)?;
            continue;
        }
        let sag = name.starts_with("$AN_CEC");
        let (table, axis, row) = match (sag, &index[..]) {
            (true, [table]) => (*table, "", None),
            (true, [table, row]) => (*table, "", Some(*row)),
            (false, [table, axis]) => (*table, *axis, None),
            (false, [table, row, axis]) => (*table, *axis, Some(*row)),
            _ => return Err((line, text.into(), ASSIGNMENT)),
        };
        let table = table.parse().map_err(|_| (line, text.into(), ASSIGNMENT))?;
        let table = tables.entry((sag, table, axis.into())).or_default();
        let letter = |text: &str| Joint::parse(text.trim_matches(['(', ')']).trim_end_matches('1'));
        match (name.rsplit('_').next().unwrap_or_default(), row) {
            (_, Some(_)) => table.values.push(number(line, right)?),
            ("STEP", _) => table.step = number(line, right)?,
            ("MIN", _) => table.first = number(line, right)?,
            ("MODULO", _) => table.modulo = right == "1",
            ("AXIS", _) if name.contains("INPUT") => table.input = letter(right),
            ("AXIS", _) => table.output = letter(right),
            _ => {}
        }
        if !sag {
            (table.input, table.output) = (letter(axis), letter(axis));
        }
    }
    let lines = lines_of(
        machine,
        &|vector: Vector| {
            let (first, second) = ("TRAFO5_BASE_TOOL_1", "TRAFO5_PART_OFFSET_1");
            let both = rotary(machine).map(|side| side.len());
            match (vector, both) {
                (Vector::Point(0), [2, 0]) => (first, 1.0),
                (Vector::Point(_), [2, 0]) => (second, -1.0),
                (Vector::Point(0), [0, 2]) => (second, -1.0),
                (Vector::Point(_), [0, 2]) => (first, 1.0),
                (Vector::Point(0), _) => (first, 1.0),
                (Vector::Point(_), _) => (second, -1.0),
                (Vector::Direction(0), _) => ("TRAFO5_AXIS1_1", 1.0),
                (Vector::Direction(_), _) => ("TRAFO5_AXIS2_1", 1.0),
            }
        },
        &vectors,
    );
    Ok(Control { lines, tables: tables.into_values().filter_map(Table::finished).collect() })
}

/// A program of a FANUC.
pub(super) fn fanuc(machine: &Machine, lines: &[Line<'_>]) -> Result<Control, Found> {
    let mut points: BTreeMap<usize, Vector3<f64>> = BTreeMap::new();
    for &(line, text) in lines.iter().filter(|(_, text)| text.starts_with('N')) {
        let wrong = || (line, text.to_string(), "N19700 R[PRM[19700]+NUMBER]");
        let (parameter, right) = text[1..].split_once(" R[PRM[").ok_or_else(wrong)?;
        let (again, added) = right.trim_end_matches(']').split_once(']').ok_or_else(wrong)?;
        let number_of: usize = parameter.parse().map_err(|_| wrong())?;
        if again != parameter || !(19700..19715).contains(&number_of) {
            return Err(wrong());
        }
        let first = 19700 + (number_of - 19700) / 3 * 3;
        points.entry(first).or_default()[(number_of - 19700) % 3] += number(line, added)?;
    }
    let point = |first: usize| points.get(&first).copied().unwrap_or_default();
    let none = Vector3::zeros();
    let lines = match &rotary(machine) {
        [table, tool] if tool.is_empty() && table.len() == 2 => {
            vec![(table[0], point(19700), none), (table[1], point(19700) + point(19703), none)]
        }
        [table, tool] if table.is_empty() && tool.len() == 2 => {
            vec![(tool[1], point(19709), none), (tool[0], point(19709) + point(19712), none)]
        }
        [table, tool] => {
            let table = table.iter().map(|&axis| (axis, point(19700), none));
            table.chain(tool.iter().map(|&axis| (axis, point(19709), none))).collect()
        }
    };
    Ok(Control { lines, tables: Vec::new() })
}

/// Rows of a kinematics description, and tables of compensation values: the errors of each axis.
pub(super) fn heidenhain(lines: &[Line<'_>]) -> Result<Numbers, Found> {
    let mut numbers = Numbers::default();
    let mut columns: Vec<usize> = Vec::new();
    let mut axis = 0;
    let screen = |direction: usize, value: f64| if direction < 3 { value } else { value.to_radians() };
    for &(line, text) in lines {
        let cells: Vec<&str> = text.split_whitespace().collect();
        let letter = |text: &str| Joint::parse(text).map(Joint::index).filter(|index| *index < 6);
        match cells[..] {
            ["DOC", ..] | ["[END]"] => {}
            [_, "Trans", direction, value, "-"] => {
                let wrong = || (line, text.to_string(), "E…0… Trans DIRECTION VALUE -");
                let direction = letter(direction).ok_or_else(wrong)?;
                let axis = cells[0].get(3..4).and_then(letter).ok_or_else(wrong)?;
                numbers.constants.insert((axis, direction), screen(direction, number(line, value)?));
            }
            [_, "Trans", direction, "-", table] => {
                let wrong = || (line, text.to_string(), "column C1 to C6 in the order X Y Z A B C");
                let column = table.split_once("..C").and_then(|(_, k)| k.parse::<usize>().ok());
                if column.and_then(|k| k.checked_sub(1)) != letter(direction) {
                    return Err(wrong());
                }
            }
            ["BEGIN", name, "MM"] => {
                axis = name.strip_suffix(".COM").and_then(letter).ok_or((line, text.into(), "C.COM"))?;
            }
            ["AXISPOS", ..] => {
                let column = |name: &&str| name.strip_prefix('C')?.parse::<usize>().ok()?.checked_sub(1);
                columns = cells[1..].iter().map(column).collect::<Option<_>>().ok_or((
                    line,
                    text.into(),
                    "C1 to C6",
                ))?;
            }
            _ if cells.len() == columns.len() + 1 => {
                let argument = number(line, cells[0])?;
                for (&direction, cell) in columns.iter().zip(&cells[1..]) {
                    let value = screen(direction, number(line, cell)?);
                    numbers.curves.entry((axis, direction)).or_default().push((argument, value));
                }
            }
            _ => return Err((line, text.into(), "rows Trans, tables BEGIN … AXISPOS … [END]")),
        }
    }
    Ok(numbers)
}

#[derive(Default)]
struct Table {
    input: Option<Joint>,
    output: Option<Joint>,
    first: f64,
    step: f64,
    values: Vec<f64>,
    modulo: bool,
}

impl Table {
    fn finished(self) -> Option<Cross> {
        let (input, output) = (self.input?, self.output?);
        let inside = |axis: Joint, value: f64| if axis.is_rotary() { value.to_radians() } else { value };
        Some(Cross {
            input,
            output,
            first: inside(input, self.first),
            step: inside(input, self.step),
            values: self.values.iter().map(|value| inside(output, *value)).collect(),
            modulo: self.modulo,
        })
    }
}

/// A vector of the first or second rotary axis.
#[derive(Clone, Copy)]
enum Vector {
    Point(usize),
    Direction(usize),
}

/// The rotary axes in the order of the transformation, with what its vectors move them by.
fn lines_of(
    machine: &Machine,
    name: &dyn Fn(Vector) -> (&'static str, f64),
    vectors: &Registers,
) -> Vec<(Joint, Vector3<f64>, Vector3<f64>)> {
    let [table, tool] = rotary(machine);
    let mixed = !table.is_empty() && !tool.is_empty();
    let axes: Vec<Joint> =
        if mixed { vec![tool[0], table[0]] } else { table.into_iter().chain(tool).collect() };
    let vector = |of: Vector| {
        let (name, sign) = name(of);
        let component = |k: usize| vectors.get(&(name.to_string(), k)).copied().unwrap_or_default();
        Vector3::new(component(0), component(1), component(2)) * sign
    };
    let sense = |axis: Joint| machine.axis(axis).map_or(1.0, |axis| axis.sense);
    axes.into_iter()
        .enumerate()
        .map(|(k, axis)| (axis, vector(Vector::Point(k)), vector(Vector::Direction(k)) * sense(axis)))
        .collect()
}

/// Rotary axes of table and tool, each from the bed outward. The spindle is none of them: the vectors begin at its line.
fn rotary(machine: &Machine) -> [Vec<Joint>; 2] {
    use trunnion_machine::Side;
    [Side::Table, Side::Tool].map(|side| {
        let axes = machine.from_bed(side).into_iter().filter(|axis| machine.spindle != Some(axis.letter));
        axes.filter(|axis| axis.is_rotary()).map(|axis| axis.letter).collect()
    })
}

/// `$NAME[1,2,X1]` as name and indices.
fn indexed(text: &str) -> Option<(&str, Vec<&str>)> {
    let (name, rest) = text.split_once('[')?;
    Some((name, rest.strip_suffix(']')?.split(',').collect()))
}
