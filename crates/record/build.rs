//! Compiles `schema/trunnion.proto` and leaves its descriptor set beside the generated code.

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=schema/trunnion.proto");
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let mut compiler = protox::Compiler::new(["schema"])?;
    compiler.include_imports(true).open_file("trunnion.proto")?;
    std::fs::write(out.join("trunnion.fds"), compiler.encode_file_descriptor_set())?;
    prost_build::compile_fds(compiler.file_descriptor_set())?;
    Ok(())
}
