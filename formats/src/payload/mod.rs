//! What stands in the chunks: metadata, the BVH, cameras, and tiles in canonical bytes.

pub mod bvh;
pub mod canonical;
pub mod metadata;
