//! One file per command.

pub mod add;
pub mod attribute;
pub mod check;
pub mod check_config;
pub mod compare;
pub mod compensation;
pub mod daemon;
pub mod demo;
pub mod devices;
pub mod diagnose;
pub mod export;
pub mod identify;
pub mod import;
pub mod ladder;
pub mod nc_program;
pub mod open;
pub mod plan;
pub mod predict;
mod progress_bar;
pub mod record;
pub mod remove;
pub mod replay;
pub mod scrub;
pub mod simulate;
pub mod volumetric;
