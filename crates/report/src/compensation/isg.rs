//! ISG CSV, read by the ISG kernel and TwinCAT CNC (`file_format ISG_CSV`).
//!
//! Columns separated by blanks, named in a header line; rows below it; `//` begins a remark; a line `#` ends a block, after
//! which a new header may follow. Position errors (X0B … C0C) stand in a block of one row without argument, component errors
//! (EXC … ECC) in a block whose first column is the argument. mm and rad; arguments mm and degrees. GRID interpolation is
//! linear. The controller computes the compensation from the error parameters; its option `negate` turns signs of axes.

use super::format::{Format, Signs, argument, header_of_tables, number, takes_all};
use trunnion_core::Joint;
use trunnion_results::{AxisErrors, Chain, CorrectionValues};

pub(super) static FORMAT: Format = Format {
    name: "isg",
    about: "ISG CSV: blocks of columns, blanks between them",
    readers: "ISG-kernel CNC, Beckhoff TwinCAT 3 CNC (`file_format ISG_CSV`)",
    source: "ISG functional description C26 / Beckhoff TF5280 Volumetric Compensation: ISG CSV format, List of parameters supported, Units of measure, Interpolation mode",
    ending: "csv",
    signs: Signs::Either,
    enter: &[
        "Name the file in the configuration of the volumetric compensation (file[0], file_format[0] ISG_CSV).",
        "Load and switch it on: #VOLCOMP OFF [ID0], #VOLCOMP [ID0 UPDATE], #VOLCOMP ON [ID0].",
    ],
    undo: &["#VOLCOMP OFF [ID0]; take the file out of the configuration."],
    unconfirmed: &["Whether a machine needs the option `negate` of an axis: the self-test shows it."],
    takes: takes_all,
    write,
};

fn write(_: &Chain, errors: &AxisErrors, values: CorrectionValues) -> String {
    let mut text: String =
        header_of_tables(errors, values).iter().map(|line| format!("// {line}\n")).collect();
    let mut blocks = Vec::new();
    let (mut names, mut numbers) = (Vec::new(), Vec::new());
    for table in &errors.axes {
        for (k, value) in table.location.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
            names.push(format!("{}0{}", Joint::ALL[k], table.axis));
            numbers.push(number(value * values.sign()));
        }
    }
    if !names.is_empty() {
        blocks.push(format!("// position errors\n{}\n{}\n", names.join(" "), numbers.join(" ")));
    }
    for table in errors.axes.iter().filter(|table| !table.positions.is_empty()) {
        let axis = &table.axis;
        let columns = Joint::ALL.map(|direction| format!("E{direction}{axis}"));
        let mut block = format!("// component errors of {axis}\n{axis} {}\n", columns.join(" "));
        for (position, twist) in table.positions.iter().zip(&table.errors) {
            let row = twist.map(|value| number(value * values.sign()));
            block += &format!("{} {}\n", argument(*position), row.join(" "));
        }
        blocks.push(block);
    }
    text += &blocks.join("#\n");
    text
}
