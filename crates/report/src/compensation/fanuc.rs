//! FANUC Series 30i: parameters of the mechanism of five-axis machining.
//!
//! Nos. 19700–19702 rotary table position, 19703–19705 vector between the rotary axes of the table, 19709–19711 vector from the tool axis
//! (the line of the spindle) to the rotary axis of the tool that is next to it, 19712–19714 from there to the other [FANUC A-79348E pp. 59, 82–84]. All at zero
//! of the rotary axes, machine axes, mm. An NC program that adds to the parameters.
//! Limits: these parameters hold places, no directions and no tables. The three-dimensional error compensation of linear axes, which [FANUC A-79351E]
//! documents, is not written.

use super::format::{Format, Signs, header};
use super::lines::{Kind, Zeros, added, kind, lines, without_lean};
use super::taken::{Component, is_spindle, taken};
use nalgebra::Vector3;
use trunnion_results::{AxisErrors, Chain, CorrectionValues};

pub(super) static FORMAT: Format = Format {
    name: "fanuc",
    about: "NC program: adds to parameters 19700–19714 by G10 L52",
    readers: "FANUC Series 30i/31i with tool center point control (G43.4)",
    source: "FANUC Series 30i-MODEL A, Tool center point control for 5-axis machining, A-79348E, pp. 59, 72–84 (http://www.cncmanuals.com/fanuc/609/)",
    ending: "nc",
    signs: Signs::OfTheControl,
    enter: &[
        "Write down parameters 19680 and 19700 to 19714, or punch all parameters: undoing needs them.",
        "Compare No. 19680 (type of mechanism) with the first lines of the file.",
        "Enable parameter writing (PWE), run the program once in MEM. It adds: a second run would add twice. Without PRM[] in your custom macros, add the numbers by hand.",
        "They act under tool center point control and tilted working plane only: measure again with a program of `nc-program --tcp`.",
    ],
    undo: &["Enter the old values of Nos. 19700 to 19714."],
    unconfirmed: &[
        "Reading a parameter as PRM[number] in a custom macro: not found in a public manual.",
        "Parameters for directions of the rotary axes and for errors over their position exist (three-dimensional rotary error compensation): no public manual with their format was found, so that nothing is written for them.",
        "Errors of the linear axes over the volume can be entered as three-dimensional error compensation (values at lattice points; FANUC A-79351E describes it). It is not built here: nothing of the linear axes is written for this control.",
        "A place for a lean of the tool axis: not found in a public manual; nothing is written for it.",
    ],
    takes,
    write,
};

fn takes(chain: &Chain, errors: &AxisErrors) -> AxisErrors {
    let kept = taken(errors, &|table, component| match component {
        _ if kind(chain).is_none() => Some("the parameters are those of two rotary axes".into()),
        Component::Location(_) if is_spindle(chain, &table.axis) => None,
        Component::Location(k) if table.rotary && k < 3 => None,
        Component::Location(_) => Some("the parameters hold places of rotary axes, no directions".into()),
        Component::Table(_) => Some("the public parameters hold no tables over an axis".into()),
    });
    without_lean(chain, kept, Zeros::Fixed)
}

fn write(chain: &Chain, errors: &AxisErrors, _: CorrectionValues) -> String {
    let values = "values are added to what stands in the parameters; unit: mm";
    let mut text = String::from("%\nO9500\n");
    let Some(kind) = kind(chain) else { return text + "M30\n%\n" };
    let [table, tool] = lines(chain, errors, Zeros::Fixed)
        .map(|side| -> Vec<Vector3<f64>> { side.iter().map(|line| line.moved_mm).collect() });
    let (number, entries) = match kind {
        Kind::TwoTable => (12, vec![(19700, table[0]), (19703, table[1] - table[0])]),
        Kind::TwoTool => (2, vec![(19709, tool[1]), (19712, tool[0] - tool[1])]),
        Kind::Mixed => (21, vec![(19700, table[0]), (19709, tool[0])]),
    };
    let remarks = header(errors, values);
    for line in remarks.iter().chain([&format!("for No. 19680 = {number}")]) {
        text += &format!("({})\n", line.replace('(', "[").replace(')', "]"));
    }
    text += "G10 L52\n";
    for (first, change_mm) in entries {
        for k in 0..3 {
            if let Some(added) = added(change_mm[k]) {
                let parameter = first + k;
                text += &format!("N{parameter} R[PRM[{parameter}]{added}]\n");
            }
        }
    }
    text + "G11\nM30\n%\n"
}
