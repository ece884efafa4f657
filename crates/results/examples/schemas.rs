//! Writes the schemas of every answer: `cargo run -p trunnion-results --example schemas`.

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
    std::fs::create_dir_all(&folder)?;
    for (name, schema) in trunnion_results::schemas() {
        let file = folder.join(format!("{name}.schema.json"));
        std::fs::write(&file, trunnion_results::schema_text(&schema)?)?;
    }
    Ok(())
}
