//! What readings say about their device in addition to their values: stuck, without value, not moving.

pub(crate) mod axes;
pub(crate) mod temperatures;
pub(crate) mod values;
