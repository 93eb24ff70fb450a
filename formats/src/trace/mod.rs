//! A whole trace: opened, written, compared and digested, tile by tile, in any order and from any thread.

mod codec;
mod compare;
mod digest;
mod fingerprint;
mod reader;
mod writer;

pub use crate::columns::paths::{BvhTopology, LeafTests, PathSink, SharedPaths};
pub use codec::{Codec, PackedColumn, Scratch, TileCodec};
pub use compare::{Difference, compare};
pub use digest::{Digest, digest};
pub use reader::Trace;
pub use writer::{Started, TraceWriter};
