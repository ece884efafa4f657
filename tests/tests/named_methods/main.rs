//! Named methods on a simulated machine whose truth is known: each recovers what was put in.

mod bench;
mod error_map;
mod two_height;
