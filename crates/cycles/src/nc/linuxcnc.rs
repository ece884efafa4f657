//! LinuxCNC, RS274/NGC.
//!
//! G93: F is the inverse of the duration of the block in minutes and must stand in every block. G4 P in seconds. `(MSG,…)`
//! shows a message, M0 stops. G64 P Q0: blending within P of the path, without merging blocks. At most 255 characters a line.

use super::dialect::Dialect;
use super::program::{Block, Program};
use super::words::{Moves, plain, short, wrapped};

pub(super) static DIALECT: Dialect = Dialect {
    name: "linuxcnc",
    controllers: "LinuxCNC 2.8 and later",
    source: "LinuxCNC documentation: G-Code Overview, G-Codes (G4, G61, G64, G93), M-Codes",
    ending: "ngc",
    duration: "G93, F = 1/min",
    dwell: "G4 P s",
    stop: "(MSG,…), M0",
    decimals: 6,
    numbered: false,
    tool_point: None,
    write,
};

fn write(program: &Program, decimals: usize) -> String {
    let mut text = format!("(TRUNNION {})\n", plain(&program.name));
    for line in DIALECT.header(program).iter().flat_map(|line| wrapped(&plain(line), 100)) {
        text += &format!("({line})\n");
    }
    text += "G21 G17 G90 G94 G40 G49 G80 G54\n";
    text += &format!("G64 P{} Q0\n", short(program.tolerance_mm, 6));
    let mut moves = Moves::new(decimals, "G1", 6);
    for block in &program.blocks {
        match block {
            Block::Remark(remark) => text += &format!("({})\n", plain(remark)),
            Block::Stop(message) => text += &format!("(MSG,{})\nM0\n", plain(message)),
            // It has none; `Program` is asked for one only where the dialect has it.
            Block::ToolPoint(_) => {}
            Block::Dwell { seconds } => text += &format!("G4 P{}\n", short(*seconds, 3)),
            Block::Feed { to, per_min } => text += &moves.feed(to, *per_min),
            Block::Timed { to, seconds } => text += &moves.timed(to, *seconds),
        }
    }
    text += moves.end();
    text + "M2\n"
}
