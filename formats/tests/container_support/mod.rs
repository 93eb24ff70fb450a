//! A small trace with every kind of chunk, and a reading of everything in a file.

#![allow(dead_code, reason = "each test binary uses its own part of this")]

pub mod forge;

use std::fs;
use std::path::{Path, PathBuf};

use rayreel_formats::container::{
    ChunkId, ChunkKind, ChunkRecord, ColumnEntry, ColumnTotals, EncodedChunk, Encoding, NONE, Reader, Writer,
};
use rayreel_formats::{Limits, Result};
use tempfile::TempDir;

/// A kind that this version does not define.
pub const NOTE: ChunkId = ChunkId { kind: ChunkKind(*b"NOTE"), frame: NONE, tile: NONE };

pub fn column(id: u8, packed: &[u8]) -> ColumnEntry {
    ColumnEntry { id, codec: id % 3, raw_len: packed.len() as u64 * 2, packed: packed.to_vec() }
}

/// The chunks of the sample, in file order.
pub fn sample() -> Vec<EncodedChunk> {
    let plain = |id, encoding, payload: &[u8]| EncodedChunk::new(id, encoding, payload).unwrap();
    let tile = |frame, tile, columns: &[ColumnEntry]| EncodedChunk::tile(ChunkId::tile(frame, tile), columns).unwrap();
    vec![
        plain(ChunkId::META, Encoding::Zstd(3), b"meta meta meta meta meta meta"),
        plain(ChunkId::BVH, Encoding::Zstd(19), &[5; 300]),
        plain(ChunkId::frame(0), Encoding::Stored, b"camera 0"),
        tile(0, 0, &[column(1, b"tree"), column(2, b"hits hits"), column(7, b"")]),
        tile(0, 1, &[column(7, b"late"), column(2, b"x")]),
        plain(NOTE, Encoding::Stored, b"note"),
        plain(NOTE, Encoding::Zstd(1), b"another note"),
        plain(ChunkId::frame(1), Encoding::Zstd(1), b""),
        tile(1, 0, &[]),
    ]
}

/// A new folder, in memory where there is such a place: these tests finish thousands of files, each forced to the disk.
pub fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

/// Writes chunks to `trace.rtrace` in a new folder.
pub fn write(chunks: &[EncodedChunk]) -> (TempDir, PathBuf) {
    let folder = folder();
    let path = folder.path().join("trace.rtrace");
    let mut writer = Writer::create(&path).unwrap();
    for chunk in chunks {
        writer.write_encoded(chunk).unwrap();
    }
    let finished = writer.finish().unwrap();
    assert_eq!(finished.len, fs::metadata(&path).unwrap().len());
    assert_eq!(finished.chunks, chunks.len() as u64);
    (folder, path)
}

/// The bytes of the sample file.
pub fn sample_bytes() -> Vec<u8> {
    let (_folder, path) = write(&sample());
    fs::read(path).unwrap()
}

/// What a column holds: id, codec, raw length, coded bytes.
pub type Column = (u8, u8, u64, Vec<u8>);

/// Everything that a file says, but not where it says it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Content {
    pub payloads: Vec<(ChunkId, Vec<u8>)>,
    pub columns: Vec<(ChunkId, Vec<Column>)>,
    pub totals: Vec<ColumnTotals>,
}

/// Reads a whole file in every way there is.
pub fn read_all(reader: &Reader) -> Result<Content> {
    let mut content = Content { payloads: Vec::new(), columns: Vec::new(), totals: reader.column_totals().to_vec() };
    for record in reader.chunks() {
        content.payloads.push((record.id, reader.read(record)?));
        if record.id.kind == ChunkKind::TILE {
            content.columns.push((record.id, read_columns(reader, record)?));
        }
    }
    Ok(content)
}

fn read_columns(reader: &Reader, record: &ChunkRecord) -> Result<Vec<Column>> {
    let directory = reader.tile_directory(record)?;
    let tile = reader.read_tile(record)?;
    assert_eq!(tile.directory, directory);
    let mut columns = Vec::new();
    for info in directory.columns() {
        let packed = reader.read_column(record, &directory, info.id)?.unwrap();
        assert_eq!(tile.column(info.id).unwrap(), (info, &packed[..]));
        columns.push((info.id, info.codec, info.raw_len, packed));
    }
    Ok(columns)
}

/// Opens bytes and reads everything.
pub fn read_bytes(bytes: &[u8]) -> Result<Content> {
    read_all(&Reader::from_bytes(bytes.to_vec(), Limits::default())?)
}

/// `NAME.partial`.
pub fn partial(path: &Path) -> PathBuf {
    rayreel_formats::container::partial_path(path).unwrap()
}

/// Writes a field and makes the CRC-32 at `crc_at` right again for the bytes from `start` up to it.
pub fn patch(bytes: &mut [u8], at: usize, field: &[u8], start: usize, crc_at: usize) {
    bytes[at..at + field.len()].copy_from_slice(field);
    let crc = crc32fast::hash(&bytes[start..crc_at]);
    bytes[crc_at..crc_at + 4].copy_from_slice(&crc.to_le_bytes());
}
