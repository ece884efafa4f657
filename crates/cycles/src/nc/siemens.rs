//! Siemens SINUMERIK 840D sl and SINUMERIK ONE.
//!
//! G93: F is the inverse of the duration of the block in minutes, in every block. G4 F in seconds stands in a block of its own
//! and leaves the feed as it is. MSG("…") shows a text until the next one, M0 stops. TRAFOOF ends five-axis transformation
//! (TRAORI), D0 tool offsets. ORIMKS: rotary axes go straight from angle to angle. G60 and G64: exact stop and continuous path.

use super::dialect::{Dialect, ToolPoint};
use super::program::{Block, Program};
use super::words::{Moves, plain, short, wrapped};

/// Longest text of a message.
const MESSAGE: usize = 120;

pub(super) static DIALECT: Dialect = Dialect {
    name: "siemens",
    controllers: "SINUMERIK 840D sl, SINUMERIK ONE",
    source: "SINUMERIK 840D sl Programming Manual Fundamentals: G93, G4, MSG, M0, TRAFOOF, G642 and CTOL",
    ending: "mpf",
    duration: "G93, F = 1/min",
    dwell: "G4 F s",
    stop: "MSG, M0",
    decimals: 4,
    numbered: false,
    tool_point: Some(ToolPoint {
        name: "TRAORI",
        check: "The tool in the spindle is the active one, D1 its length. TRAORI stands for the transformation of the correction (TRAORI(2) for the second).",
        source: "SINUMERIK 840D sl Programming Manual Job Planning: TRAORI, TRAFOOF, ORIMKS",
    }),
    write,
};

fn write(program: &Program, decimals: usize) -> String {
    let mut text = format!("; TRUNNION {}\n", plain(&program.name));
    for line in DIALECT.header(program).iter().flat_map(|line| wrapped(&plain(line), 100)) {
        text += &format!("; {line}\n");
    }
    let offset = if program.tool_point { "D1" } else { "D0" };
    text += &format!("TRAFOOF\nG710 G17 G90 G94 G40 {offset}\nG54\n");
    text += &format!("G642 CTOL={}\n", short(program.tolerance_mm, 4));
    let mut moves = Moves::new(decimals, "G1", 4);
    for block in &program.blocks {
        match block {
            Block::Remark(remark) => text += &format!("; {}\n", plain(remark)),
            Block::Stop(message) => {
                let lines = wrapped(&plain(message), MESSAGE);
                let comments: String = lines.iter().skip(1).map(|line| format!("; {line}\n")).collect();
                text += &format!("MSG(\"{}\")\n{comments}M0\nMSG()\n", lines[0]);
            }
            // A change of the transformation may deselect the offset.
            Block::ToolPoint(true) => text += "TRAORI\nG54\nORIMKS\n",
            Block::ToolPoint(false) => text += "TRAFOOF\nG54\n",
            Block::Dwell { seconds } => text += &format!("G4 F{}\n", short(*seconds, 3)),
            Block::Feed { to, per_min } => text += &moves.feed(to, *per_min),
            Block::Timed { to, seconds } => text += &moves.timed(to, *seconds),
        }
    }
    text += moves.end();
    text + "M30\n"
}
