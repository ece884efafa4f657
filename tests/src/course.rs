//! The states a device goes through.

use trunnion_acquire::{DeviceState, DeviceStatus, SessionEnd};

/// States in order, without those of attempts; Streaming alone is no course.
#[derive(Debug, Default)]
pub struct Course {
    ends: [u64; 8],
    /// What it went through.
    pub states: Vec<DeviceState>,
}

impl Course {
    /// From a status on.
    pub fn from(status: &DeviceStatus) -> Self {
        Self { ends: status.ends, states: Vec::new() }
    }

    /// Takes a status. A state between two looks left its count behind.
    pub fn take(&mut self, status: &DeviceStatus) {
        let ended: Vec<DeviceState> =
            (0..self.ends.len()).filter(|&k| status.ends[k] > self.ends[k]).filter_map(state_after).collect();
        self.ends = status.ends;
        for state in ended.into_iter().chain([status.state]) {
            let is_new = self.states.last() != Some(&state);
            let is_first = self.states.is_empty() && state == DeviceState::Streaming;
            if is_new && !is_first && !matches!(state, DeviceState::Connecting | DeviceState::Stopped) {
                self.states.push(state);
            }
        }
    }

    /// How often sessions ended in this way.
    pub fn ends(&self, end: &SessionEnd) -> u64 {
        self.ends[end.kind()]
    }
}

/// The state a session's end of this kind leaves.
fn state_after(kind: usize) -> Option<DeviceState> {
    match SessionEnd::KINDS[kind] {
        "absent" => Some(DeviceState::Absent),
        "silent" => Some(DeviceState::Silent),
        "wrong-device" => Some(DeviceState::WrongDevice),
        "refused" => Some(DeviceState::Refused),
        "disconnected" | "protocol" | "restarted" => Some(DeviceState::Failed),
        _ => None,
    }
}
