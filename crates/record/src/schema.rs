//! The protobuf messages and their descriptor set, generated from `schema/trunnion.proto`. The generated files are committed, so
//! that no build needs the generator; `tests/all/schema.rs` writes and compares them.

include!("../schema/trunnion.rs");

/// The serialized `FileDescriptorSet`, embedded in every recording as schema data.
pub const FILE_DESCRIPTOR_SET: &[u8] = include_bytes!("../schema/trunnion.fds");
