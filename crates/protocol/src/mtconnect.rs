//! MTConnect
