//! optoncdt
