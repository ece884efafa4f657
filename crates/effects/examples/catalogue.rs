//! Writes the catalogue and its pictures: `cargo run -p trunnion-effects --example catalogue`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let docs = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/design"));
    std::fs::create_dir_all(docs.join("catalogue"))?;
    std::fs::write(docs.join("catalogue.md"), trunnion_effects::catalogue_markdown())?;
    for picture in trunnion_effects::catalogue_pictures() {
        std::fs::write(docs.join("catalogue").join(picture.file), picture.svg)?;
    }
    Ok(())
}
