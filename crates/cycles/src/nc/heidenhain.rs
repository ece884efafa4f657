//! Heidenhain Klartext: TNC 640, TNC 620, iTNC 530.
//!
//! Blocks are numbered. Klartext has no inverse time: with M129 (no TCPM) F is the contouring feed of the axes programmed in
//! the block, mm and degrees counted alike, so F = length of the block over its duration. Whether a control counts a block
//! of linear and rotary axes so is for its builder to set: the header says how long a sweep must take. Dwell is cycle 9, in
//! seconds; STOP waits for the operator, who reads the comment before it; cycle 32 bounds the rounding of corners; M127: rotary
//! axes go where they are commanded, not the shorter way.

use super::dialect::{Dialect, ToolPoint};
use super::program::{Block, Program, Target};
use super::words::{Words, identifier, plain, short, wrapped};

/// Longest comment.
const COMMENT: usize = 100;

pub(super) static DIALECT: Dialect = Dialect {
    name: "heidenhain",
    controllers: "TNC 640, TNC 620, iTNC 530 (Klartext)",
    source: "TNC 640 User's Manual for Klartext Programming: L, STOP, cycles 9 (dwell time) and 32 (tolerance), M127, M129, FUNCTION TCPM F CONT; input formats: positions 5.4, feed rates 5.3, dwell 4.3",
    ending: "h",
    duration: "F in mm per minute, degrees counted as mm",
    dwell: "cycle 9",
    stop: "comment, STOP",
    decimals: 4,
    numbered: false,
    tool_point: Some(ToolPoint {
        name: "FUNCTION TCPM",
        check: "TOOL CALL of that tool before the start; its length refers to the centre of the ball.",
        source: "TNC 620 User's Manual DIN/ISO 5/2013, p. 340; TNC 426/430 User's Manual, M128 on tilting tables; TNC 640 Klartext: FUNCTION TCPM, FUNCTION RESET TCPM",
    }),
    write,
};

fn write(program: &Program, decimals: usize) -> String {
    let name = identifier(&program.name);
    let mut lines = vec![format!("BEGIN PGM {name} MM")];
    lines.extend(comments(&format!("TRUNNION {}", program.name)));
    lines.extend(DIALECT.header(program).iter().flat_map(|line| comments(line)));
    lines.extend([
        "CYCL DEF 32.0 TOLERANCE".into(),
        format!("CYCL DEF 32.1 T{}", short(program.tolerance_mm, 4)),
    ]);
    lines.push("M127".into());
    lines.push("M129".into());
    let mut words = Words::new(decimals);
    for block in &program.blocks {
        match block {
            Block::Remark(remark) => lines.extend(comments(remark)),
            Block::Stop(message) => {
                lines.extend(comments(message));
                lines.push("STOP".into());
            }
            // F CONT: F is that of the programmed axes, as without; the axes go straight from angle to angle.
            Block::ToolPoint(true) => lines.push("FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS".into()),
            Block::ToolPoint(false) => lines.push("FUNCTION RESET TCPM".into()),
            Block::Dwell { seconds } => lines.extend([
                "CYCL DEF 9.0 DWELL TIME".into(),
                format!("CYCL DEF 9.1 DWELL {}", short(*seconds, 3)),
            ]),
            Block::Feed { to, per_min } => lines.extend(line(&mut words, to, |_| *per_min)),
            Block::Timed { to, seconds } => {
                lines.extend(line(&mut words, to, |length| length / seconds * 60.0));
            }
        }
    }
    lines.extend(["CYCL DEF 32.0 TOLERANCE".into(), "CYCL DEF 32.1".into(), "M30".into()]);
    lines.push(format!("END PGM {name} MM"));
    lines.iter().enumerate().map(|(number, line)| format!("{number} {line}\n")).collect()
}

fn line(words: &mut Words, to: &Target, feed: impl Fn(f64) -> f64) -> Option<String> {
    let changed = words.changed(to);
    let signed = |number: &str| if number.starts_with('-') { number.into() } else { format!("+{number}") };
    let axes: String =
        changed.words.iter().map(|(letter, number)| format!(" {letter}{}", signed(number))).collect();
    (!axes.is_empty()).then(|| format!("L{axes} R0 F{}", short(feed(changed.length), 3)))
}

fn comments(text: &str) -> Vec<String> {
    wrapped(&plain(text), COMMENT).into_iter().map(|line| format!("; {line}")).collect()
}
