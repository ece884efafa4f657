//! The whole shop floor.
