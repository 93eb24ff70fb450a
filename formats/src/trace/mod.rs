//! A whole trace: opened, written, compared and digested, tile by tile, in any order and from any thread.

mod codec;
mod compare;
mod digest;
mod edit;
mod fingerprint;
mod reader;
mod rewrite;
mod writer;

pub use crate::columns::paths::{BvhTopology, LeafTests, PathSink, SharedPaths};
pub use codec::{Codec, PackedColumn, Scratch, TileCodec};
pub use compare::{Difference, compare};
pub use digest::{Digest, digest};
pub use edit::with_needed;
pub use reader::Trace;
pub use rewrite::{Keep, Part, rewrite};
pub use writer::{Started, TraceWriter};
