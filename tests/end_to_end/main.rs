//! The program `trunnion` from end to end, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod attribute;
mod bad_input;
mod bar_zero;
mod broker;
mod combined;
mod compensation;
mod correct;
mod dated;
mod demo;
mod devices;
mod eighty_columns;
mod history;
mod history_on_page;
mod host_faults;
mod hybrid;
#[path = "../src/json_schema.rs"]
mod json_schema;
mod kept;
mod long_lists;
mod methods;
mod nc_program;
mod numbers_on_page;
mod one_answer;
mod outputs;
mod outside_data;
mod own_machine;
#[path = "../src/page_status.rs"]
mod page_status;
mod plan;
mod program;
mod record;
mod report;
mod robot;
mod schemes;
#[path = "../src/secret_forms.rs"]
mod secret_forms;
mod secrets;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../src/section.rs"]
mod section;
mod service_killed;
mod setting_up;
mod shop;
mod slips;
mod spindle;
mod story;
mod streams;
#[path = "../src/three_probes.rs"]
mod three_probes;
mod volumetric;

/// What was printed as one line: where the terminal breaks a sentence is no part of it.
fn one_line(printed: &[u8]) -> String {
    String::from_utf8_lossy(printed).split_whitespace().collect::<Vec<_>>().join(" ")
}
