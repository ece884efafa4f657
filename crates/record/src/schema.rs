//! The generated protobuf messages and their descriptor set.

include!(concat!(env!("OUT_DIR"), "/trunnion.rs"));

/// The serialized `FileDescriptorSet`, embedded in every recording as schema data.
pub const FILE_DESCRIPTOR_SET: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/trunnion.fds"));
