//! Fanuc series 30i/31i/32i and alike.
//!
//! G93 inverse time (an option of the control): F is 60 divided by the duration of the block in seconds, in every block.
//! G04 P in milliseconds. M00 stops; the comment before it is what the program screen shows. G49 ends tool length
//! compensation and with it tool centre point control (G43.4, G43.5). Comments take capital letters.

use super::dialect::{Dialect, ToolPoint};
use super::program::{Block, Program};
use super::words::{Moves, fixed, plain, wrapped};

/// Numbers that follow from a name: in the range that users may write (O0001–O7999), above the low ones that people give by hand.
const NUMBERS: std::ops::RangeInclusive<u32> = 1000..=7999;

pub(super) static DIALECT: Dialect = Dialect {
    name: "fanuc",
    controllers: "Fanuc 30i, 31i, 32i model B with inverse time feed (G93)",
    source: "Fanuc 30i-B operator's manual B-64484EN: G93 (inverse time feed), G04, G49, M00; increment systems IS-B, IS-C",
    ending: "nc",
    duration: "G93, F = 1/min",
    dwell: "G04 P ms",
    stop: "comment, M00",
    decimals: 3,
    numbered: true,
    tool_point: Some(ToolPoint {
        name: "G43.4 H1",
        check: "H1 is the length of that tool. Parameter 19696: bit 5 (WKP) 0, positions on the table; bit 6 (RFC) 1, rotary axes at the feed of the program. \
                No G49 before the spindle is retracted by hand: it may move Z by the length.",
        source: "FANUC A-79348E, Tool center point control for 5-axis machining, pp. 19, 20, 78",
    }),
    write,
};

fn write(program: &Program, decimals: usize) -> String {
    let number = program.number.unwrap_or_else(|| number_of(&program.name, program.tool_point));
    let mut text = format!("%\nO{number:04} ({})\n", comment(&program.name));
    let own = match program.number {
        Some(_) => format!("Number {number:04} as it was asked for."),
        None => format!("Number {number:04} follows from the name of the cycle; --number takes another."),
    };
    let own = format!("{own} The control keeps one program of a number.");
    for line in DIALECT.header(program).iter().chain([&own]).flat_map(|line| wrapped(&comment(line), 60)) {
        text += &format!("({line})\n");
    }
    let mut moves = Moves::new(decimals, "G01", 3);
    text += match program.tool_point {
        false => "G21 G17 G90 G94 G40 G49 G80\nG54 G64\n",
        // G49 may move Z by the length: the length acts from the first way up.
        true => {
            moves.begins_with("G43 H1 ");
            "G21 G17 G90 G94 G40 G80\nG54 G64\n"
        }
    };
    for block in &program.blocks {
        match block {
            Block::Remark(remark) => text += &lines(remark),
            Block::Stop(message) => text += &format!("{}M00\n", lines(message)),
            Block::ToolPoint(true) => text += &format!("G43.4 H1{}\n", moves.linear()),
            // M30 ends it without a move.
            Block::ToolPoint(false) => {}
            Block::Dwell { seconds } => text += &format!("G04 P{}\n", fixed(seconds * 1e3, 0)),
            Block::Feed { to, per_min } => text += &moves.feed(to, *per_min),
            Block::Timed { to, seconds } => text += &moves.timed(to, *seconds),
        }
    }
    text += moves.end();
    text + "M30\n%\n"
}

/// Programs of other names have other numbers, as far as 3500 go; the same cycle with tool centre point control has the next one.
/// FNV-1a of 32 bits [Fowler, Noll, Vo, IETF draft-eastlake-fnv].
fn number_of(name: &str, tool_point: bool) -> u32 {
    let hash =
        name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    let pairs = (NUMBERS.end() - NUMBERS.start()).div_ceil(2);
    NUMBERS.start() + 2 * (hash % pairs) + u32::from(tool_point)
}

fn lines(text: &str) -> String {
    wrapped(&comment(text), 60).iter().map(|line| format!("({line})\n")).collect()
}

/// Capital letters; a colon would be read as the letter O of a program number.
fn comment(text: &str) -> String {
    plain(text).to_ascii_uppercase().replace([':', '%'], " ")
}
