//! Which replies of which device tests disturb one by one, and what must hold: the same for every device that is asked. The table of
//! docs/measured/faults.md is written from the entries that the tests run.

use crate::devices::ReplyFault;

/// A device whose replies are disturbed one by one.
pub struct Replies {
    /// Name of the driver.
    pub driver: &'static str,
    /// The first so many.
    pub count: u64,
    /// What they are.
    pub what: &'static str,
    /// A reply that is late comes after its timeout.
    pub late_s: f64,
    /// What holds, in addition to readings in the end.
    pub holds: &'static str,
}

/// optoNCDT.
pub const OPTONCDT: Replies = Replies {
    driver: "optoncdt",
    count: 6,
    what: "of the start: OUTPUT NONE, GETINFO, MEASRATE, OUTADD_RS422, GETOUTINFO_RS422, OUTPUT RS422",
    late_s: 0.9,
    holds: "in the first session",
};
/// DL-RS1A.
pub const KEYENCE: Replies = Replies {
    driver: "keyence-dl-rs1a",
    count: 6,
    what: "of the start, and values",
    late_s: 0.4,
    holds: "in the first session; no value is that of a request before",
};
/// Indicators.
pub const ASCII: Replies = Replies {
    driver: "ascii",
    count: 6,
    what: "values",
    late_s: 0.7,
    holds: "in the first session; no value is that of a request before",
};
/// SDO answers.
pub const CANOPEN: Replies = Replies {
    driver: "canopen-slcan",
    // Of the first node and the begin of the second: every kind of answer is among them.
    count: 32,
    what: "SDO of the start: numbers, a name in segments, objects that are not there",
    late_s: 0.7,
    holds: "in the first session, every value that of its node; a node that begins again instead of answering costs at most one session",
};
/// NMT.
pub const CAN_COMMANDS: Replies = Replies {
    driver: "canopen-slcan",
    count: 2,
    what: "commands of the host (NMT): pre-operational, start",
    late_s: 0.7,
    holds: "every value that of its node; a start that does not come costs one session",
};
/// Heartbeats.
pub const CAN_HEARTBEATS: Replies = Replies {
    driver: "canopen-slcan",
    count: 4,
    what: "heartbeats",
    late_s: 0.7,
    holds: "every value that of its node; at most one session lost",
};
/// TPDOs.
pub const CAN_VALUES: Replies = Replies {
    driver: "canopen-slcan",
    // Of two SYNCs: each node.
    count: 8,
    what: "values (TPDO)",
    // After the next SYNC.
    late_s: 0.012,
    holds: "in the first session, every value that of its node; each SYNC has an answer or is counted as lost, once",
};
/// linuxcncrsh.
pub const LINUXCNC: Replies = Replies {
    driver: "linuxcnc",
    count: 8,
    what: "of the start (hello, echo, units), then positions with status, line and program, and positions alone",
    late_s: 0.5,
    holds: "at most one session lost; no position is that of a request before",
};
/// Agents of MTConnect.
pub const MTCONNECT: Replies = Replies {
    driver: "mtconnect",
    count: 6,
    what: "documents of the start (/probe, /current), then parts of the stream",
    late_s: 3.5,
    holds: "each position that of its stamp, every hole a gap; a document that is no document, or a closed connection, costs one session",
};
/// Servers of OPC UA.
pub const OPCUA: Replies = Replies {
    driver: "opcua",
    count: 20,
    what: "messages of the server: of the connection that asks for endpoints, of the session, then publications",
    // The client waits for 2 s.
    late_s: 2.5,
    holds: "each position that of its stamp, every hole a gap; at most one session lost",
};
/// All of them.
pub const ALL: [&Replies; 10] = [
    &OPTONCDT,
    &KEYENCE,
    &ASCII,
    &CANOPEN,
    &CAN_COMMANDS,
    &CAN_HEARTBEATS,
    &CAN_VALUES,
    &LINUXCNC,
    &MTCONNECT,
    &OPCUA,
];

impl Replies {
    /// Each reply late, doubled, missing, together with the next, and cut in half.
    pub fn faults(&self) -> impl Iterator<Item = (u64, ReplyFault)> {
        let faults = [
            ReplyFault::Late(self.late_s),
            ReplyFault::Doubled,
            ReplyFault::Dropped,
            ReplyFault::Merged,
            ReplyFault::Cut,
        ];
        (0..self.count).flat_map(move |number| faults.map(|fault| (number, fault)))
    }
}
