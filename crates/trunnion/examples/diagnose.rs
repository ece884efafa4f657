//! Five lines from a recording to the missing effect: `cargo run -p trunnion --example diagnose -- run.mcap`.

fn main() -> Result<(), trunnion::Error> {
    let run = trunnion::open(path())?;
    let answer = run.fit(&run.base_model())?.diagnose()?;
    println!("{}", answer.summary());
    Ok(())
}

/// The recording named on the command line, else a committed points file.
fn path() -> String {
    let committed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
    std::env::args().nth(1).unwrap_or_else(|| committed.into())
}
