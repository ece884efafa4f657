//! The table of docs/measured/faults.md from the entries that the tests run.

use crate::section::write_or_compare;
use trunnion_hil_sim::replies::{ALL, Replies};

#[test]
fn the_table_of_reply_faults_names_what_is_run() {
    let row = |device: &&Replies| {
        let Replies { driver, count, what, late_s, holds } = device;
        format!("| `{driver}` | {count}: {what} | {late_s} s | pass | pass | pass | pass | {holds} |\n")
    };
    let head = "| | replies | late by | doubled | dropped | merged with the next | cut in half | readings in the end |\n|---|---|---|---|---|---|---|---|\n";
    let table = format!("{head}{}", ALL.iter().map(row).collect::<String>());
    write_or_compare("docs/measured/faults.md", "reply faults", &table);
}
