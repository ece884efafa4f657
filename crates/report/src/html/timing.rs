//! Time quality: what is known of every stream's clock.

use crate::markup::{element, table};
use crate::time_quality::{ABOUT, HEAD, NUMERIC, rows, sentences};
use trunnion_results::TimeQuality;

pub fn section(timing: &[TimeQuality]) -> String {
    if timing.is_empty() {
        return String::new();
    }
    let of = |quality: &TimeQuality| {
        let items: String = sentences(quality).iter().map(|text| element("li", text)).collect();
        let list = if items.is_empty() { String::new() } else { format!("<ul>{items}</ul>") };
        table(&format!("Streams of {}", quality.run), &HEAD, &NUMERIC, &rows(quality)) + &list
    };
    let runs: String = timing.iter().map(of).collect();
    format!("<section><h2>Time quality</h2>\n{}\n{runs}</section>\n", element("p", ABOUT))
}
