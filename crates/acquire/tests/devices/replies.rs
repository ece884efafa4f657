//! Faults of replies, the same for every device that is asked: which of its replies, and what must hold. The table of
//! docs/measured/faults.md is written from the entries that the tests run.

use crate::section::write_or_compare;
use trunnion_hil_sim::devices::ReplyFault;

/// A device whose replies are disturbed one by one.
pub struct Replies {
    driver: &'static str,
    /// The first so many, and what they are.
    pub count: u64,
    what: &'static str,
    /// A reply that is late comes after its timeout.
    late_s: f64,
    /// What holds, in addition to readings in the end.
    holds: &'static str,
}

pub const OPTONCDT: Replies = Replies {
    driver: "optoncdt",
    count: 6,
    what: "of the start: OUTPUT NONE, GETINFO, MEASRATE, OUTADD_RS422, GETOUTINFO_RS422, OUTPUT RS422",
    late_s: 0.9,
    holds: "in the first session",
};
pub const KEYENCE: Replies = Replies {
    driver: "keyence-dl-rs1a",
    count: 6,
    what: "of the start, and values",
    late_s: 0.4,
    holds: "in the first session; no value is that of a request before",
};
pub const ASCII: Replies = Replies {
    driver: "ascii",
    count: 6,
    what: "values",
    late_s: 0.7,
    holds: "in the first session; no value is that of a request before",
};
pub const CANOPEN: Replies = Replies {
    driver: "canopen-slcan",
    // Of the first node and the begin of the second: every kind of answer is among them.
    count: 32,
    what: "SDO of the start: numbers, a name in segments, objects that are not there",
    late_s: 0.7,
    holds: "in the first session, every value that of its node; a node that begins again instead of answering costs at most one session",
};
pub const LINUXCNC: Replies = Replies {
    driver: "linuxcnc",
    count: 8,
    what: "of the start (hello, echo, units), then positions with status, line and program, and positions alone",
    late_s: 0.5,
    holds: "at most one session lost; no position is that of a request before",
};
const ALL: [&Replies; 5] = [&OPTONCDT, &KEYENCE, &ASCII, &CANOPEN, &LINUXCNC];

impl Replies {
    /// Each reply late, doubled, missing and together with the next.
    pub fn faults(&self) -> impl Iterator<Item = (u64, ReplyFault)> {
        let faults =
            [ReplyFault::Late(self.late_s), ReplyFault::Doubled, ReplyFault::Dropped, ReplyFault::Merged];
        (0..self.count).flat_map(move |number| faults.map(|fault| (number, fault)))
    }
}

#[test]
fn the_table_of_reply_faults_names_what_is_run() {
    let row = |device: &&Replies| {
        let Replies { driver, count, what, late_s, holds } = device;
        format!("| `{driver}` | {count}: {what} | {late_s} s | pass | pass | pass | {holds} |\n")
    };
    let head = "| | replies | late by | doubled | dropped | merged with the next | readings in the end |\n|---|---|---|---|---|---|---|\n";
    let table = format!("{head}{}", ALL.iter().map(row).collect::<String>());
    write_or_compare("docs/measured/faults.md", "reply faults", &table);
}
