//! The committed messages and descriptor sets are what the schemas give.

use std::path::Path;

/// Names of the generated files, and what they are generated from.
const GENERATED: [(&str, &[&str]); 2] = [
    ("trunnion", &["trunnion.proto"]),
    (
        "foxglove",
        &[
            "foxglove/Event.proto",
            "foxglove/FrameTransforms.proto",
            "foxglove/JointStates.proto",
            "foxglove/Log.proto",
            "foxglove/PoseInFrame.proto",
            "foxglove/SceneUpdate.proto",
        ],
    ),
];

#[test]
fn the_committed_messages_are_generated_from_the_schemas() {
    let schema = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    for (package, files) in GENERATED {
        let mut compiler = protox::Compiler::new([&schema]).unwrap();
        compiler.include_imports(true).open_files(files).unwrap();
        let generated = tempfile::tempdir().unwrap();
        let messages = compiler.file_descriptor_set();
        prost_build::Config::new().out_dir(generated.path()).compile_fds(messages).unwrap();
        let descriptors = generated.path().join(format!("{package}.fds"));
        std::fs::write(descriptors, compiler.encode_file_descriptor_set()).unwrap();
        for name in [format!("{package}.rs"), format!("{package}.fds")] {
            let now = std::fs::read(generated.path().join(&name)).unwrap();
            let committed = schema.join(&name);
            if std::env::var_os("TRUNNION_WRITE_DOCS").is_some() {
                std::fs::write(&committed, &now).unwrap();
            }
            let is_current = std::fs::read(&committed).unwrap() == now;
            assert!(is_current, "{} is old: run this test with TRUNNION_WRITE_DOCS=1", committed.display());
        }
    }
}
