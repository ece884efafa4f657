//! Etalon exchange format, variant "Vendor", as far as it is documented by those who read it.
//!
//! Like an INI file: a block begins with the name of the parameter in brackets; `VALUE = …` is a constant (position errors
//! X0B … C0C), `Gridpoints = { argument value … }` a table, one pair a line. `//` begins a remark. mm and rad; arguments mm
//! and degrees. The format is proprietary and its whole description not public: written here is what the ISG documentation
//! shows of it, and nothing else.

use super::format::{Format, Signs, argument, header_of_tables, number, takes_all};
use trunnion_core::Joint;
use trunnion_results::{AxisErrors, Chain, CorrectionValues};

pub(super) static FORMAT: Format = Format {
    name: "etalon",
    about: "Etalon exchange, variant \"Vendor\", as far as ISG and Beckhoff document it",
    readers: "ISG-kernel CNC, Beckhoff TwinCAT 3 CNC (`ETALON_EXCHANGE`)",
    source: "ISG functional description C26 / Beckhoff TF5280 Volumetric Compensation: Etalon Exchange Format, Units of measure",
    ending: "txt",
    signs: Signs::Either,
    enter: &[
        "Name the file in the configuration of the volumetric compensation (file[0], file_format[0] ETALON_EXCHANGE).",
        "Switch it on: #VOLCOMP ON [ID0].",
    ],
    undo: &["#VOLCOMP OFF [ID0]; take the file out of the configuration."],
    unconfirmed: &[
        "The whole Etalon format is not public; written is what the ISG documentation shows of it.",
    ],
    takes: takes_all,
    write,
};

fn write(_: &Chain, errors: &AxisErrors, values: CorrectionValues) -> String {
    let mut text: String =
        header_of_tables(errors, values).iter().map(|line| format!("// {line}\n")).collect();
    for table in &errors.axes {
        for (k, value) in table.location.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
            let name = format!("{}0{}", Joint::ALL[k], table.axis);
            text += &format!("[{name}]\nVALUE = {}\n", number(value * values.sign()));
        }
    }
    for table in errors.axes.iter().filter(|table| !table.positions.is_empty()) {
        for k in 0..6 {
            let name = format!("E{}{}", Joint::ALL[k], table.axis);
            text += &format!("[{name}]\nGridpoints = {{\n");
            for (position, twist) in table.positions.iter().zip(&table.errors) {
                let value = twist[k] * values.sign();
                text += &format!("{} {}\n", argument(*position), number(value));
            }
            text += &format!("}} // end of {name}\n");
        }
    }
    text
}
