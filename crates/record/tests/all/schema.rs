//! The committed messages and descriptor set are what `schema/trunnion.proto` gives.

use std::path::Path;

#[test]
fn the_committed_messages_are_generated_from_the_schema() {
    let schema = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    let mut compiler = protox::Compiler::new([&schema]).unwrap();
    compiler.include_imports(true).open_file("trunnion.proto").unwrap();
    let generated = tempfile::tempdir().unwrap();
    let messages = compiler.file_descriptor_set();
    prost_build::Config::new().out_dir(generated.path()).compile_fds(messages).unwrap();
    std::fs::write(generated.path().join("trunnion.fds"), compiler.encode_file_descriptor_set()).unwrap();
    for name in ["trunnion.rs", "trunnion.fds"] {
        let now = std::fs::read(generated.path().join(name)).unwrap();
        let committed = schema.join(name);
        if std::env::var_os("TRUNNION_WRITE_DOCS").is_some() {
            std::fs::write(&committed, &now).unwrap();
        }
        let is_current = std::fs::read(&committed).unwrap() == now;
        assert!(is_current, "{} is old: run this test with TRUNNION_WRITE_DOCS=1", committed.display());
    }
}
