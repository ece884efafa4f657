//! Which SYNCs a node has answered: what did not come, came late, or came twice.

use crate::link::Link;
use trunnion_core::HostTime;

/// A node may go on answering so many SYNCs late. More answers that are missed at once and do not come together were lost.
const MOST_LATE: u64 = 2;

/// The answers of a node; of one that is not asked by SYNC, its values.
#[derive(Debug)]
pub(super) struct Answers {
    node: u8,
    /// Last SYNC index or count, with its moment.
    pub last: Option<(u64, HostTime)>,
    /// After how many SYNCs it answers, once it has.
    every: u64,
    late: Option<Late>,
    late_reported: bool,
}

/// Answers that were missed and may still come.
#[derive(Clone, Copy, Debug)]
struct Late {
    /// Moment of the first value that may be that of the SYNC before.
    since: HostTime,
    answers: u64,
}

impl Answers {
    /// None yet.
    pub fn of(node: u8) -> Self {
        Self { node, last: None, every: u64::MAX, late: None, late_reported: false }
    }

    /// A second answer to one SYNC. Where one before was missed, the values since then may each be that of the SYNC before; which, nobody
    /// knows. Else it is a frame that came twice: its sender saw an error behind the last bit that its receivers look at, and repeated it.
    pub fn came_again(&mut self, arrival: HostTime, link: &mut Link) {
        // A node that is silent for longer ends the session: what was missed before that has nothing to do with it.
        let Some(late) = self.late.take().filter(|late| arrival - late.since <= link.silence) else {
            link.counters.resyncs += 1;
            return;
        };
        let answers = late.answers - 1;
        self.late = (answers > 0).then_some(Late { answers, ..late });
        let id = self.node;
        // The one that is missing was counted when it was missed.
        let reason = format!("node {id} answered later than the next SYNC; its moment is unknown");
        link.gap(late.since, arrival, Some(0), reason);
        if !std::mem::replace(&mut self.late_reported, true) {
            link.log(true, format!("node {id} answers later than the next SYNC: take a longer sync_ms"));
        }
    }

    /// An answer. Values are missing between the SYNCs that were answered, whenever the answers were read.
    pub fn came(&mut self, sequence: u64, every: Option<u64>, moment: HostTime, link: &mut Link) {
        if let Some(every) = every {
            self.every = every;
            // Those of before the first answer are of no run, and yet their answers may come.
            let (last, at) = self.last.unwrap_or((0, moment));
            let lost = (sequence.saturating_sub(last) / every).saturating_sub(1);
            if lost > 0 {
                let before = self.late.filter(|late| moment - late.since <= link.silence);
                let late = before.unwrap_or(Late { since: moment, answers: 0 });
                self.late = Some(Late { answers: late.answers + lost, ..late });
            }
            // A second TPDO of one answer says nothing new.
            if lost == 0 && sequence != last {
                self.late = self.late.filter(|late| late.answers <= MOST_LATE);
            }
            if lost > 0 && self.last.is_some() {
                self.missed(at, moment, lost, link);
            }
        }
        self.last = Some((sequence, moment));
    }

    /// At the end: others answered up to this SYNC of this moment; the first was sent after `began`.
    pub fn ended(&self, began: HostTime, answered: u64, until: HostTime, link: &mut Link) {
        match self.last {
            None => link.gap(began, until, None, format!("node {} sends no values", self.node)),
            Some((last, at)) => {
                let lost = (answered - last) / self.every;
                if lost > 0 {
                    self.missed(at, until, lost, link);
                }
            }
        }
    }

    fn missed(&self, from: HostTime, to: HostTime, lost: u64, link: &mut Link) {
        link.gap(from, to, Some(lost), format!("node {} missed SYNCs", self.node));
    }
}
