//! Writes the certification table: `cargo run --release -p trunnion-methods --example certify [TRIALS]`.

use std::path::Path;

mod document;
mod experiment;
mod guides;
mod monte_carlo;
mod pairs;
mod shapes;
mod strd;

/// Trials of the Monte Carlo in docs/measured/certification.md.
const TRIALS: usize = 100_000;

fn main() -> std::io::Result<()> {
    let wanted = std::env::args().nth(1);
    let trials = match wanted.as_deref().map(str::parse) {
        None => TRIALS,
        Some(Ok(trials)) => trials,
        Some(Err(why)) => {
            eprintln!("the number of trials is not a whole number: {why}; for example 2000");
            std::process::exit(2);
        }
    };
    let text = document::document(trials);
    print!("{text}");
    if wanted.is_none() {
        let docs = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/measured"));
        std::fs::write(docs.join("certification.md"), text)?;
    }
    Ok(())
}
