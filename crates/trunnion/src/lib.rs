//! From recordings to answers: the library that command line, service and page share.

pub mod analysis;
pub mod page;
pub mod recorded;
pub mod recording;
pub mod timing;
