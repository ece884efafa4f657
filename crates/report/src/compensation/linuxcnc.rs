//! LinuxCNC: a HAL component between the motion controller and the drives.
//!
//! It reads the commanded positions of all joints, computes how tool and table deviate by the errors of all axes, and adds the
//! opposite to the motor commands of the linear joints; the feedback goes back without it, so that the screen shows the nominal
//! position [LinuxCNC HAL comp]. The pin `enable` switches it, over a second. The C below is a file of its own, without HAL, so
//! that a test can compile and run it.
//! Limits: to first order; orientation stays as it is; beyond the measured range the last row of a table counts.

use super::format::{Format, Signs, argument, header, number, takes_all};
use trunnion_core::Joint;
use trunnion_results::{AxisErrors, AxisTable, Chain, ChainJoint, CorrectionValues};

/// What the component computes, without the tables.
const COMPUTED: &str = include_str!("../control/linuxcnc.c");

pub(super) static FORMAT: Format = Format {
    name: "linuxcnc",
    about: "HAL component `trunnion_correction.comp`: location errors and tables of all axes",
    readers: "LinuxCNC 2.8, 2.9 (`halcompile --install`)",
    source: "LinuxCNC documentation, HAL Component Generator (http://linuxcnc.org/docs/html/hal/comp.html)",
    ending: "comp",
    signs: Signs::OfTheControl,
    enter: &[
        "Install: sudo halcompile --install trunnion_correction.comp (package linuxcnc-uspace-dev). The file must have this name.",
        "In the HAL file: loadrt trunnion_correction, and addf trunnion-correction servo-thread after motion-controller.",
        "For every joint: net from joint.N.pos-cmd to trunnion-correction.x-pos (y, z, b, c: the names of the axes).",
        "For every linear joint: joint.N.motor-pos-cmd to x-cmd, x-out to what the drive got before, its feedback to x-fb-in, x-fb to joint.N.motor-pos-fb.",
        "With a tool of length or an offset of the machine zero: set tool-x, tool-y, tool-z and zero-x, zero-y, zero-z, mm.",
        "Switch it on: halcmd setp trunnion-correction.enable 1",
    ],
    undo: &["halcmd setp trunnion-correction.enable 0"],
    unconfirmed: &[],
    takes: takes_all,
    write,
};

fn write(chain: &Chain, errors: &AxisErrors, _: CorrectionValues) -> String {
    let values =
        "tables hold errors (actual - nominal), mm and rad over mm and degrees; SIGN -1 applies the opposite";
    let mut text: String = header(errors, values).iter().map(|line| format!("// {line}\n")).collect();
    text +=
        "component trunnion_correction \"Corrects the tool point by the identified errors of the axes\";\n";
    text += "option singleton yes;\n";
    text += "pin in bit enable = FALSE \"apply the correction\";\n";
    text += "pin out float gain \"share of the correction that acts, 0 to 1\";\n";
    for letter in ["x", "y", "z"] {
        text += &format!("param rw float tool_{letter} = 0 \"tool point in tool axes, mm\";\n");
        text += &format!(
            "param rw float zero_{letter} = 0 \"joint position where the machine file has its zero, mm\";\n"
        );
    }
    let joints: Vec<(&ChainJoint, bool)> = with_side(chain).collect();
    for (joint, _) in &joints {
        let name = joint.axis.to_lowercase();
        text += &format!("pin in float {name}_pos \"commanded position of joint {}\";\n", joint.axis);
        if !joint.rotary {
            text += &format!("pin in float {name}_cmd \"motor command from the controller\";\n");
            text += &format!("pin out float {name}_out \"motor command with the correction\";\n");
            text += &format!("pin in float {name}_fb_in \"motor feedback\";\n");
            text += &format!("pin out float {name}_fb \"motor feedback without the correction\";\n");
        }
    }
    text += "function _;\nlicense \"Apache-2.0\";\n;;\n#include \"rtapi_math.h\"\n#ifndef M_PI\n#define M_PI 3.14159265358979323846\n#endif\n";
    text += &core(errors, &joints);
    text + &function(&joints)
}

/// The joints of both sides from the bed outward; true on the side of the tool.
fn with_side(chain: &Chain) -> impl Iterator<Item = (&ChainJoint, bool)> {
    chain.table.iter().map(|joint| (joint, false)).chain(chain.tool.iter().map(|joint| (joint, true)))
}

/// Tables and computation, in plain C.
fn core(errors: &AxisErrors, joints: &[(&ChainJoint, bool)]) -> String {
    let mut text = format!("\n/* begin: core */\n#define JOINTS {}\n#define SIGN (-1.0)\n\n", joints.len());
    text += "struct joint {\n    int tool_side, rotary;\n    double direction[3], through[3], sense, location[6], first, last;\n    int whole_turn, rows;\n    const double (*errors)[6];\n};\n\n";
    let none = AxisTable::default();
    let table_of = |joint: &ChainJoint| errors.axes.iter().find(|table| table.axis == joint.axis);
    for (joint, _) in joints {
        let Some(table) = table_of(joint).filter(|table| !table.errors.is_empty()) else { continue };
        text += &format!("static const double errors_{}[][6] = {{\n", joint.axis.to_lowercase());
        for row in &table.errors {
            text += &format!("    {{ {} }},\n", row.map(number).join(", "));
        }
        text += "};\n\n";
    }
    text += "static const struct joint joints[JOINTS] = {\n";
    for (joint, on_tool) in joints {
        let table = table_of(joint).unwrap_or(&none);
        let ends =
            [table.positions.first(), table.positions.last()].map(|end| argument(*end.unwrap_or(&0.0)));
        let rows = match table.errors.is_empty() {
            true => "0".into(),
            false => format!("errors_{}", joint.axis.to_lowercase()),
        };
        text += &format!(
            "    {{ {}, {}, {{ {} }}, {{ {} }}, {}, {{ {} }}, {}, {}, {}, {}, {rows} }},\n",
            u8::from(*on_tool),
            u8::from(joint.rotary),
            joint.direction.map(number).join(", "),
            joint.through_mm.map(number).join(", "),
            joint.sense,
            table.location.map(number).join(", "),
            ends[0],
            ends[1],
            u8::from(table.whole_turn),
            table.errors.len(),
        );
    }
    text + "};\n\n" + COMPUTED + "/* end: core */\n\n"
}

/// What the servo thread calls.
fn function(joints: &[(&ChainJoint, bool)]) -> String {
    let mut text = String::from(
        "/* The correction comes and goes over this time, s: no step of the drives. */\n#define RAMP_S 1.0\n\nFUNCTION(_) {\n",
    );
    let positions: Vec<String> = joints
        .iter()
        .map(|(joint, _)| {
            let name = joint.axis.to_lowercase();
            match Joint::LINEAR.iter().any(|letter| letter.as_str() == joint.axis) {
                true => format!("{name}_pos - zero_{name}"),
                false => format!("{name}_pos"),
            }
        })
        .collect();
    text += &format!("    const double position[JOINTS] = {{ {} }};\n", positions.join(", "));
    text += "    const double tool[3] = { tool_x, tool_y, tool_z };\n    double travel[3] = { 0, 0, 0 };\n";
    text += "    gain += (enable ? 1.0 : -1.0) * fperiod / RAMP_S;\n    if (gain > 1.0) gain = 1.0;\n    if (gain < 0.0) gain = 0.0;\n";
    text += "    correction(position, tool, travel);\n";
    let linear = joints.iter().filter(|(joint, _)| !joint.rotary);
    for (k, (joint, _)) in linear.enumerate() {
        let name = joint.axis.to_lowercase();
        let travel = if k < 3 { format!(" + gain * travel[{k}]") } else { String::new() };
        let back = if k < 3 { format!(" - gain * travel[{k}]") } else { String::new() };
        text += &format!("    {name}_out = {name}_cmd{travel};\n    {name}_fb = {name}_fb_in{back};\n");
    }
    text + "}\n"
}
