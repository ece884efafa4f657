//! Plain comma-separated values: one number a line, for spreadsheets and other programs.
//!
//! `parameter,axis,argument,argument_unit,value,value_unit`: a location error (EX0C, …) has no argument, a component error
//! (EXC, …) has one line for each position. Lines that begin with `#` are remarks, the first of them names the format.

use super::format::{Format, Signs, argument, header_of_tables, number, takes_all};
use trunnion_core::Joint;
use trunnion_results::{AxisErrors, Chain, CorrectionValues};

pub(super) static FORMAT: Format = Format {
    name: "csv",
    about: "one number a line: `parameter,axis,argument,argument_unit,value,value_unit`",
    readers: "spreadsheets, other programs",
    source: "this file; symbols of ISO 230-1",
    ending: "csv",
    signs: Signs::Either,
    enter: &[
        "Read the file into the program that feeds the control: each line is one number with its unit, and the head of the file says its sign.",
    ],
    undo: &["Take the file out of that program."],
    unconfirmed: &[],
    takes: takes_all,
    write,
};

fn write(_: &Chain, errors: &AxisErrors, values: CorrectionValues) -> String {
    let mut text = String::from("# trunnion-compensation/1\n");
    for line in header_of_tables(errors, values) {
        text += &format!("# {line}\n");
    }
    text += "parameter,axis,argument,argument_unit,value,value_unit\n";
    for table in &errors.axes {
        let axis = &table.axis;
        let argument_unit = if table.rotary { "deg" } else { "mm" };
        for (k, value) in table.location.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
            let direction = Joint::ALL[k];
            text += &format!(
                "E{direction}0{axis},{axis},,,{},{}\n",
                number(value * values.sign()),
                unit(direction)
            );
        }
        for k in 0..6 {
            let direction = Joint::ALL[k];
            for (position, twist) in table.positions.iter().zip(&table.errors) {
                text += &format!(
                    "E{direction}{axis},{axis},{},{argument_unit},{},{}\n",
                    argument(*position),
                    number(twist[k] * values.sign()),
                    unit(direction)
                );
            }
        }
    }
    text
}

fn unit(direction: Joint) -> &'static str {
    if direction.is_rotary() { "rad" } else { "mm" }
}
