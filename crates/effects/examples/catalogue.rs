//! Prints the catalogue: `cargo run -p trunnion-effects --example catalogue > docs/catalogue.md`.

fn main() {
    print!("{}", trunnion_effects::catalogue_markdown());
}
