//! Adds what is missing, effect by effect, and prints the ladder: `cargo run -p trunnion --example ladder -- run.mcap`.

/// Effects that are added at most.
const MOST_EFFECTS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = trunnion::open(path())?;
    let mut fit = run.fit(&run.base_model())?;
    for _ in 0..MOST_EFFECTS {
        let Some(effect) = fit.diagnose()?.best() else { break };
        let step = fit.add(&effect)?.dated("2026-03-01")?;
        println!("+ {effect}: {:.2} -> {:.2} µm", step.row().error_before_um, step.row().error_after_um);
        fit = step.fit().clone();
    }
    println!("{}", trunnion::results::to_json(&fit.model().ladder())?);
    Ok(())
}

/// The recording named on the command line, else a committed points file.
fn path() -> String {
    let committed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
    std::env::args().nth(1).unwrap_or_else(|| committed.into())
}
