//! A model against a run it was not fitted to: `cargo run -p trunnion --example predict -- fitted.mcap other.mcap`.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut paths = std::env::args().skip(1);
    let (run, other) = (paths.next().unwrap_or_else(committed), paths.next().unwrap_or_else(committed));
    let run = trunnion::open(run)?;
    let prediction = run.fit(&run.base_model())?.add("gravity-sag:B")?.predict(&trunnion::open(other)?)?;
    println!("{}", trunnion::results::to_json(&prediction)?);
    Ok(())
}

fn committed() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv").into()
}
