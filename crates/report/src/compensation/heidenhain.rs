//! HEIDENHAIN iTNC 530, TNC 640: rows of the kinematics description and compensation-value tables of KinematicsComp.
//!
//! A row `Trans AXIS COORD` shifts or turns what follows in the chain; errors stand before the row `MachAxis` of their axis: place and
//! direction as COORD, component errors as a column C1 … C6 of the table of the axis in COMPTAB, `A..C2` is column C2 of the table
//! of A [HEIDENHAIN iTNC 530 HSCI pp. 680, 684]. Linear values mm, angles degrees. After `MachBase` the chain runs towards the workpiece.
//! Limits: axes on the side of the workpiece. Sign and order on the side of the tool are not public.

use super::format::{Format, Signs, argument, header, number};
use super::taken::{on_table, taken};
use trunnion_core::Joint;
use trunnion_core::convert::deg_from_rad;
use trunnion_results::{AxisErrors, AxisTable, Chain, CorrectionValues};

pub(super) static FORMAT: Format = Format {
    name: "heidenhain",
    about: "rows for the kinematics description (`Trans`, COORD, COMPTAB) and tables C1 to C6 of each axis",
    readers: "HEIDENHAIN iTNC 530 and TNC 640 with KinematicsComp (option 52)",
    source: "HEIDENHAIN Technical Manual iTNC 530 HSCI (7/2013), pp. 666, 670, 680, 684, 686, 722 (https://www.easymanua.ls/heidenhain/itnc-530-hsci/manual/716772)",
    ending: "txt",
    signs: Signs::OfTheControl,
    enter: &[
        "Save the kinematics description and the *.CMA and *.COM files (cycle 450 stores the kinematics).",
        "Insert the rows of each block directly before the row MachAxis of its axis. The rows before them must have reached the line of the axis. Without KinematicsComp only rows X, Y, Z of COORD are possible.",
        "Make one *.COM table for each axis with the columns C1 to C6, name it in the *.CMA table and activate its line.",
        "They act under M128, FUNCTION TCPM and PLANE: measure again with a program of `nc-program --tcp`.",
    ],
    undo: &[
        "Delete the inserted rows and deactivate the line of the *.CMA table, or restore the kinematics with cycle 450.",
    ],
    unconfirmed: &[
        "Sign of COORD and of the columns C1 to C6: the manual enters the errors themselves, without a figure.",
        "Axes on the side of the tool (before MachBase): nothing is written for them.",
        "Error along a rotary axis in columns C4 to C6: the manual recommends columns 1 to 18.",
    ],
    takes,
    write,
};

fn takes(chain: &Chain, errors: &AxisErrors) -> AxisErrors {
    taken(errors, &|table, _| {
        let why = "sign and order of rows on the side of the tool are not public";
        (!on_table(chain, &table.axis)).then(|| why.into())
    })
}

fn write(_: &Chain, errors: &AxisErrors, _: CorrectionValues) -> String {
    let values =
        "values = error (actual - nominal), as the description of the actual machine; units: mm, degrees";
    let mut text: String = header(errors, values).iter().map(|line| format!("; {line}\n")).collect();
    for table in &errors.axes {
        text += &format!("; before the row MachAxis {}\nDOC KEY AXIS COORD COMPTAB\n", table.axis);
        for k in 0..6 {
            let (direction, axis) = (Joint::ALL[k], &table.axis);
            if table.location[k] != 0.0 {
                let value = number(screen(k, table.location[k]));
                text += &format!("E{direction}0{axis} Trans {direction} {value} -\n");
            }
            if is_in(table, k) {
                text += &format!("E{direction}{axis} Trans {direction} - {axis}..C{}\n", k + 1);
            }
        }
    }
    for table in errors.axes.iter().filter(|table| !table.positions.is_empty()) {
        let columns: Vec<usize> = (0..6).filter(|&k| is_in(table, k)).collect();
        let names: Vec<String> = columns.iter().map(|k| format!("C{}", k + 1)).collect();
        text +=
            &format!("; table of {}\nBEGIN {}.COM MM\nAXISPOS {}\n", table.axis, table.axis, names.join(" "));
        for (position, row) in table.positions.iter().zip(&table.errors) {
            let values: Vec<String> = columns.iter().map(|&k| number(screen(k, row[k]))).collect();
            text += &format!("{} {}\n", argument(*position), values.join(" "));
        }
        text += "[END]\n";
    }
    text
}

fn is_in(table: &AxisTable, component: usize) -> bool {
    table.errors.iter().any(|row| row[component] != 0.0)
}

/// mm stay, rad become degrees.
fn screen(component: usize, value: f64) -> f64 {
    if component < 3 { value } else { deg_from_rad(value) }
}
