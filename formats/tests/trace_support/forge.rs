//! Traces with lies in them, under checksums that hold: chunks are taken out of a file, changed, and written to a new
//! one.

use rayreel_formats::Limits;
use rayreel_formats::container::{ChunkId, ChunkKind, ColumnEntry, EncodedChunk, Encoding, Reader, Writer};

use super::whole::folder;

/// A chunk, unpacked.
#[derive(Clone, Debug)]
pub enum Chunk {
    Payload(ChunkId, Vec<u8>),
    Tile(ChunkId, Vec<ColumnEntry>),
}

/// The chunks of a file, in order. Columns stay as they are coded.
pub fn take_apart(bytes: &[u8]) -> Vec<Chunk> {
    let reader = Reader::from_bytes(bytes.to_vec(), Limits::default()).expect("a good file");
    let chunk = |record| {
        let payload: &rayreel_formats::container::ChunkRecord = record;
        if payload.id.kind != ChunkKind::TILE {
            return Chunk::Payload(payload.id, reader.read(payload).expect("a good chunk"));
        }
        let directory = reader.tile_directory(payload).expect("a good directory");
        let entry = |info: &rayreel_formats::container::ColumnInfo| ColumnEntry {
            id: info.id,
            codec: info.codec,
            raw_len: info.raw_len,
            packed: reader.read_column(payload, &directory, info.id).expect("a good column").expect("it is there"),
        };
        Chunk::Tile(payload.id, directory.columns().iter().map(entry).collect())
    };
    reader.chunks().iter().map(chunk).collect()
}

/// A file of these chunks, with checksums, lengths and index as they should be.
pub fn put_together(chunks: &[Chunk]) -> Vec<u8> {
    let folder = folder();
    let path = folder.path().join("forged.rtrace");
    let mut writer = Writer::create(&path).expect("a new file");
    for chunk in chunks {
        let encoded = match chunk {
            Chunk::Payload(id, payload) => EncodedChunk::new(*id, Encoding::Zstd(1), payload),
            Chunk::Tile(id, columns) => EncodedChunk::tile(*id, columns),
        };
        writer.write_encoded(&encoded.expect("a chunk")).expect("it is written");
    }
    let finished = writer.finish().expect("a whole file");
    std::fs::read(finished.path).expect("the file can be read")
}

/// All byte strings that a lie can be told in: payloads, and columns as their codec packed them; plain ones unpacked.
pub fn change(chunks: &mut [Chunk], mut f: impl FnMut(ChunkId, Option<u8>, &mut Vec<u8>)) {
    for chunk in chunks {
        match chunk {
            Chunk::Payload(id, payload) => f(*id, None, payload),
            Chunk::Tile(id, columns) => {
                for column in columns {
                    if column.codec == 0 {
                        let mut raw = zstd::decode_all(&column.packed[..]).expect("a good frame");
                        f(*id, Some(column.id), &mut raw);
                        column.raw_len = raw.len() as u64;
                        column.packed = zstd::bulk::compress(&raw, 1).expect("zstd packs anything");
                    } else {
                        f(*id, Some(column.id), &mut column.packed);
                    }
                }
            }
        }
    }
}
