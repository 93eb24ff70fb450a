//! The container: opaque payloads with names, checksums and an index, in a file that survives being cut short.
//!
//! ```text
//! file header | chunk | chunk | ... | INDX chunk | trailer
//! chunk  = header (name, lengths, checksums) | payload
//! TILE payload = column directory | column | column | ...
//! ```
//!
//! [`Writer`] streams chunks to `NAME.partial` and renames it at the end; [`Writer::resume`] continues one that was cut
//! short. [`Reader`] reads finished files by name; [`scan()`] and [`repair()`] do what can be done with damaged ones.
//!
//! Invariants: every byte of a finished file is covered by a checksum. No input makes this code panic, loop, or
//! allocate more than its [`Limits`](crate::Limits) allow. The same chunks in the same order give the same bytes. What
//! the payloads mean is not here. `FORMAT.md` specifies every byte.

mod chunk_file;
mod chunk_header;
mod encoded;
mod encoding;
mod file_header;
mod index;
mod reader;
mod repair;
mod resume;
mod scan;
mod source;
mod tile;
mod trailer;
mod walk;
mod wire;
mod writer;

pub use crate::id::{ChunkId, ChunkKind, FormatVersion, NONE};
pub use chunk_file::TilePayload;
pub use chunk_header::{CHUNK_HEADER_LEN, ChunkRecord};
pub use encoded::EncodedChunk;
pub use encoding::Encoding;
pub(crate) use encoding::{compress, decompress};
pub use file_header::MAGIC;
pub use index::ColumnTotals;
pub use reader::Reader;
pub use repair::{RepairReport, repair};
pub use resume::Resumed;
pub use scan::{DamagedRange, Scan, scan, scan_source};
pub use source::Source;
pub use tile::{ColumnEntry, ColumnInfo, TileDirectory};
pub use writer::{Finished, Writer, partial_path};
