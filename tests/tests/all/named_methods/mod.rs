//! Named methods on a simulated machine whose truth is known: each recovers what was put in.

mod bench;
mod error_map;
mod rotary_values;
mod two_height;
