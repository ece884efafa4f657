//! Reading compensation files: ISG CSV, Etalon exchange, plain CSV; what is written for controls goes to `control_files`.
//!
//! Values are offsets in mm and angles in rad, arguments mm and degrees. A remark of the file must say `values = error` or
//! `values = correction`: nothing is guessed about the sign.

use super::control::Control;
use super::numbers::{Found, Line, Numbers, number};
use super::{Compensation, Table, control_files};
use trunnion_core::{AxisValues, Joint, Problem, Problems, Twist};
use trunnion_machine::Machine;

impl Compensation {
    /// Reads a file of any format that `machine` uses; `file` is shown in problems.
    ///
    /// # Errors
    /// The first thing that is not understood, with its line and what would be.
    pub fn parse(machine: &Machine, file: &str, text: &str) -> Result<Self, Problems> {
        let problem = |(line, found, allowed): (usize, String, &str)| Problem {
            file: file.into(),
            line,
            column: 0,
            found,
            allowed: allowed.into(),
            advice: String::new(),
        };
        read(machine, text).map_err(|found| problem(found).into())
    }
}

fn read(machine: &Machine, text: &str) -> Result<Compensation, Found> {
    let of_control = |control: Control| Compensation {
        location: AxisValues::default(),
        tables: Vec::new(),
        control: Some(control),
    };
    if text.contains("$MC_TRAFO5_") || text.contains("NEWCONF") {
        return control_files::siemens(machine, &lines(text, ";")).map(of_control);
    }
    if text.contains("G10 L52") {
        return control_files::fanuc(machine, &lines(text, "(")).map(of_control);
    }
    if text.contains("MachAxis") {
        // Errors of the actual machine, as the manual enters them.
        return assemble(&control_files::heidenhain(&lines(text, ";"))?, 1.0);
    }
    let sign = sign(text)?;
    let remark = if text.starts_with("# trunnion-compensation/1") { "#" } else { "//" };
    let lines = lines(text, remark);
    let numbers = if remark == "#" {
        plain(&lines)
    } else if lines.iter().any(|(_, line)| line.starts_with('[')) {
        etalon(&lines)
    } else {
        isg(&lines)
    };
    assemble(&numbers?, sign)
}

/// Lines with something before the remark.
fn lines<'a>(text: &'a str, remark: &str) -> Vec<Line<'a>> {
    text.lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.split(remark).next().unwrap_or_default().trim()))
        .filter(|(_, line)| !line.is_empty())
        .collect()
}

/// +1 when the file holds errors, −1 when it holds corrections.
fn sign(text: &str) -> Result<f64, Found> {
    let allowed = "a remark \"values = error\" or \"values = correction\"";
    for (i, line) in text.lines().enumerate() {
        if let Some((_, rest)) = line.split_once("values = ") {
            return match rest.split([' ', ';']).next() {
                Some("error") => Ok(1.0),
                Some("correction") => Ok(-1.0),
                _ => Err((i + 1, format!("values = {rest}"), allowed)),
            };
        }
    }
    Err((1, "does not say whether it holds errors or corrections".into(), allowed))
}

/// `parameter,axis,argument,argument_unit,value,value_unit`
fn plain(lines: &[Line<'_>]) -> Result<Numbers, Found> {
    let columns = "parameter,axis,argument,argument_unit,value,value_unit";
    let mut numbers = Numbers::default();
    match lines.first() {
        Some((_, header)) if *header == columns => {}
        other => return Err((other.map_or(1, |(line, _)| *line), "no header".into(), columns)),
    }
    for &(line, row) in &lines[1..] {
        let cells: Vec<&str> = row.split(',').collect();
        let [parameter, _, argument, argument_unit, value, unit] = cells[..] else {
            return Err((line, row.into(), columns));
        };
        let (rotary_axis, angle) = (argument_unit == "deg", unit == "rad");
        let wrong = |(axis, direction): (usize, usize)| {
            (direction >= 3) != angle || (!argument.is_empty() && (axis >= 3) != rotary_axis)
        };
        let value = number(line, value)?;
        if argument.is_empty() {
            let key = constant(line, parameter.trim_start_matches('E'))?;
            if wrong(key) {
                return Err((line, row.into(), "mm for X Y Z, rad for A B C"));
            }
            numbers.constants.insert(key, value);
        } else {
            let key = component(line, parameter)?;
            if wrong(key) {
                return Err((line, row.into(), "mm for X Y Z, rad for A B C; arguments mm and deg"));
            }
            numbers.curves.entry(key).or_default().push((number(line, argument)?, value));
        }
    }
    Ok(numbers)
}

/// Blocks between lines `#`: a header of names, rows of numbers.
fn isg(lines: &[Line<'_>]) -> Result<Numbers, Found> {
    let mut numbers = Numbers::default();
    for block in lines.split(|(_, line)| *line == "#") {
        let Some((&(line, header), rows)) = block.split_first() else { continue };
        let names: Vec<&str> = header.split_whitespace().collect();
        let argument = Joint::parse(names[0]);
        for &(line, row) in rows {
            let cells: Vec<&str> = row.split_whitespace().collect();
            if cells.len() != names.len() {
                return Err((
                    line,
                    format!("{} numbers", cells.len()),
                    "as many numbers as names in the header",
                ));
            }
            for (name, cell) in names.iter().zip(&cells).skip(usize::from(argument.is_some())) {
                let value = number(line, cell)?;
                if argument.is_none() {
                    numbers.constants.insert(constant(line, name)?, value);
                    continue;
                }
                let key = component(line, name)?;
                if argument != Some(Joint::ALL[key.0]) {
                    return Err((
                        line,
                        format!("{name} over {}", names[0]),
                        "errors of the axis that is the argument",
                    ));
                }
                numbers.curves.entry(key).or_default().push((number(line, cells[0])?, value));
            }
        }
        if rows.is_empty() {
            return Err((line, header.into(), "a row of numbers below the header"));
        }
    }
    Ok(numbers)
}

/// `[NAME]`, then `VALUE = …` or `Gridpoints = {`, pairs, `}`.
fn etalon(lines: &[Line<'_>]) -> Result<Numbers, Found> {
    let mut numbers = Numbers::default();
    let mut name = "";
    let mut inside = false;
    for &(line, text) in lines {
        if let Some(inner) = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            name = inner;
        } else if let Some(value) = text.strip_prefix("VALUE =") {
            numbers.constants.insert(constant(line, name)?, number(line, value.trim())?);
        } else if text == "Gridpoints = {" {
            inside = true;
        } else if text == "}" {
            inside = false;
        } else {
            let pair: Vec<&str> = text.split_whitespace().collect();
            let (true, [argument, value]) = (inside, &pair[..]) else {
                return Err((
                    line,
                    text.into(),
                    "[NAME], VALUE = number, Gridpoints = {, pairs of numbers, }",
                ));
            };
            let point = (number(line, argument)?, number(line, value)?);
            numbers.curves.entry(component(line, name)?).or_default().push(point);
        }
    }
    Ok(numbers)
}

/// `X0C`: direction, zero, axis.
fn constant(line: usize, name: &str) -> Result<(usize, usize), Found> {
    letters(name, 0, 2)
        .filter(|_| name.len() == 3 && name.as_bytes()[1] == b'0')
        .ok_or_else(|| (line, name.into(), "a position error such as X0C"))
}

/// `EXC`: direction, axis.
fn component(line: usize, name: &str) -> Result<(usize, usize), Found> {
    letters(name, 1, 2)
        .filter(|_| name.len() == 3 && name.starts_with('E'))
        .ok_or_else(|| (line, name.into(), "a component error such as EXC"))
}

/// (axis, direction) from the letters at these places.
fn letters(name: &str, direction: usize, axis: usize) -> Option<(usize, usize)> {
    let letter = |at: usize| name.get(at..=at).and_then(Joint::parse).filter(|l| l.index() < 6);
    Some((letter(axis)?.index(), letter(direction)?.index()))
}

fn assemble(numbers: &Numbers, sign: f64) -> Result<Compensation, Found> {
    let mut location = AxisValues::<Twist>::default();
    for (&(axis, direction), &value) in &numbers.constants {
        location.0[axis] += unit(direction) * (sign * value);
    }
    let mut tables = Vec::new();
    for axis in Joint::ALL {
        let mut table: Option<Table> = None;
        for (&(_, direction), points) in numbers.curves.iter().filter(|((of, _), _)| *of == axis.index()) {
            let inside = |argument: f64| if axis.is_rotary() { argument.to_radians() } else { argument };
            let positions: Vec<f64> = points.iter().map(|(argument, _)| inside(*argument)).collect();
            if positions.len() < 2 || positions.windows(2).any(|pair| pair[1] <= pair[0]) {
                return Err((0, format!("the table of {axis}"), "two or more rows with rising arguments"));
            }
            let table = table.get_or_insert_with(|| Table {
                axis,
                errors: vec![Twist::default(); positions.len()],
                positions: positions.clone(),
            });
            if table.positions != positions {
                return Err((
                    0,
                    format!("the tables of {axis}"),
                    "the same arguments for all errors of an axis",
                ));
            }
            for (error, (_, value)) in table.errors.iter_mut().zip(points) {
                *error += unit(direction) * (sign * value);
            }
        }
        tables.extend(table);
    }
    Ok(Compensation { location, tables, control: None })
}

fn unit(direction: usize) -> Twist {
    let along = nalgebra::Vector3::ith(direction % 3, 1.0);
    if direction < 3 { Twist::translation(along) } else { Twist::rotation(along) }
}
