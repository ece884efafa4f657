//! Faults of a measuring device itself: its value sticks, what it measures leaves its range, it is another device.

use super::faults::Fault;

/// Which of these faults a device has at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct ValueFaults {
    /// First and last moment of the value that sticks, s.
    stuck_s: (f64, f64),
    /// First and last moment out of range, s.
    out_s: (f64, f64),
    /// Another device has taken its place.
    pub wrong_identity: bool,
}

impl Default for ValueFaults {
    fn default() -> Self {
        let never = (f64::INFINITY, f64::NEG_INFINITY);
        Self { stuck_s: never, out_s: never, wrong_identity: false }
    }
}

impl ValueFaults {
    /// True for the faults kept here.
    pub fn are(fault: &Fault) -> bool {
        matches!(fault, Fault::StuckValue { .. } | Fault::OutOfRange { .. } | Fault::WrongIdentity)
    }

    pub fn suffer(&mut self, fault: Fault, now_s: f64) {
        match fault {
            Fault::StuckValue { duration_s } => self.stuck_s = (now_s, now_s + duration_s),
            Fault::OutOfRange { duration_s } => self.out_s = (now_s, now_s + duration_s),
            Fault::WrongIdentity => self.wrong_identity = true,
            _ => {}
        }
    }

    /// The moment whose value the device shows at `t_s`: `t_s`, or that at which it stuck.
    pub fn seen_s(&self, t_s: f64) -> f64 {
        if within(self.stuck_s, t_s) { self.stuck_s.0 } else { t_s }
    }

    /// True when what is measured at `t_s` lies outside the range.
    pub fn is_out(&self, t_s: f64) -> bool {
        within(self.out_s, t_s)
    }
}

fn within((from_s, to_s): (f64, f64), t_s: f64) -> bool {
    from_s <= t_s && t_s < to_s
}
