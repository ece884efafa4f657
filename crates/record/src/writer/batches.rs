//! Samples that wait to be written together.

use trunnion_core::HostTime;

/// Samples in a full batch.
const BATCH_SAMPLES: usize = 256;

/// Samples waiting for their batch to fill, by channel, with the arrival of the first.
pub(super) struct Batches<K, S>(Vec<(K, HostTime, Vec<S>)>);

impl<K, S> Default for Batches<K, S> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<K: PartialEq + Copy, S> Batches<K, S> {
    /// Adds a sample; hands back the batch when it is full.
    pub(super) fn push(&mut self, key: K, sample: S, arrival: HostTime) -> Option<Vec<S>> {
        let at = self.0.iter().position(|(other, _, _)| *other == key).unwrap_or_else(|| {
            self.0.push((key, arrival, Vec::with_capacity(BATCH_SAMPLES)));
            self.0.len() - 1
        });
        let (_, first, batch) = &mut self.0[at];
        if batch.is_empty() {
            *first = arrival;
        }
        batch.push(sample);
        (batch.len() >= BATCH_SAMPLES).then(|| std::mem::take(batch))
    }

    /// Hands back the batches whose first sample arrived at a time that `which` accepts.
    pub(super) fn take(&mut self, which: impl Fn(HostTime) -> bool) -> Vec<(K, Vec<S>)> {
        let ready = self.0.iter_mut().filter(|(_, first, batch)| !batch.is_empty() && which(*first));
        ready.map(|(key, _, batch)| (*key, std::mem::take(batch))).collect()
    }
}
