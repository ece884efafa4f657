//! Virtual devices that speak the real protocols over real ports, each with a clock of its own.
