//! mtconnect
