//! The page: recordings, what was found in them, and what is measured, for a browser (docs/use/page.md).
//!
//! Who may call what is decided in `guard`, connections are counted in `accept`, recordings are found in
//! `runs` and analysed by a process of their own (`analyst`). Limits keep a page that is attacked small: one analysis at a time, calls and connections counted by computer; nothing here waits for a device.

mod accept;
mod access;
mod address;
mod analysed;
mod analyst;
mod answer;
mod assets;
mod calls;
mod context;
mod cycle_calls;
mod filed_calls;
mod grid;
mod guard;
mod live;
mod login;
mod method_calls;
mod places;
mod question;
mod runs;
mod set_up_calls;
mod shared;
mod stamp;

pub use accept::serve;
pub use access::{Access, AccessError, Lan};
pub use address::{AddressError, USUAL_ADDRESS, address};
pub use analysed::answer_questions;
pub use analyst::PageAnalyst;
pub use grid::page_cycle;
pub use guard::OWN_HEADER;
pub use runs::Runs;
pub use shared::Shared;
pub use stamp::own_model;
