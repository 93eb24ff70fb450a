//! Changes inside a trace under checksums that hold: it is taken apart, changed, and put together again.

use std::fs;

use anyhow::{Result, anyhow};
use rayreel_formats::Limits;
use rayreel_formats::container::{ChunkId, ChunkKind, ColumnEntry, EncodedChunk, Encoding, Reader, Writer};

use crate::mutate::{self, change};
use crate::place;
use crate::random::Random;

/// A chunk: its payload, or its columns as they are coded.
enum Chunk {
    Payload(ChunkId, Vec<u8>),
    Tile(ChunkId, Vec<ColumnEntry>),
}

/// What of a trace is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parts {
    /// Anything.
    All,
    /// The columns of tiles only.
    Columns,
}

/// Changes a trace: mostly one of its parts, sometimes the order or number of its chunks, sometimes bytes of the file itself.
/// What is no trace is changed as bytes.
pub fn change_trace(bytes: &mut Vec<u8>, parts: Parts, random: &mut Random) {
    if parts == Parts::All && random.once_in(8) {
        return change(bytes, &[], &[], random);
    }
    match changed(bytes, parts, random) {
        Ok(new) => *bytes = new,
        Err(_) => change(bytes, &[], &[], random),
    }
}

fn changed(bytes: &[u8], parts: Parts, random: &mut Random) -> Result<Vec<u8>> {
    let mut chunks = take_apart(bytes)?;
    if chunks.is_empty() {
        return Err(anyhow!("nothing to change"));
    }
    if parts == Parts::All && random.once_in(10) {
        let (at, to) = (random.below(chunks.len()), random.below(chunks.len()));
        match random.below(3) {
            0 => drop(chunks.remove(at)),
            1 => chunks.swap(at, to),
            _ => renumber(&mut chunks[at], random),
        }
        return put_together(&chunks);
    }
    let tiles = |chunk: &Chunk| matches!(chunk, Chunk::Tile(..));
    let choice: Vec<usize> = (0..chunks.len()).filter(|at| parts == Parts::All || tiles(&chunks[*at])).collect();
    if choice.is_empty() {
        return Err(anyhow!("no tile"));
    }
    match &mut chunks[choice[random.below(choice.len())]] {
        Chunk::Payload(_, payload) => change(payload, &[], &[], random),
        Chunk::Tile(_, columns) if !columns.is_empty() => {
            let at = random.below(columns.len());
            change_column(&mut columns[at], random)?;
        }
        Chunk::Tile(..) => {}
    }
    put_together(&chunks)
}

/// Changes a column, or what its directory says of it.
fn change_column(column: &mut ColumnEntry, random: &mut Random) -> Result<()> {
    if random.once_in(20) {
        match random.below(3) {
            0 => column.id = random.below(6) as u8,
            1 => column.codec = random.below(3) as u8,
            _ => column.raw_len = [0, 1, column.raw_len + 1, 1 << 20, 1 << 31, u64::MAX][random.below(6)],
        }
        return Ok(());
    }
    if column.codec == 0 {
        let mut raw = zstd::bulk::decompress(&column.packed, 1 << 24)?;
        change(&mut raw, &[], &[], random);
        column.raw_len = raw.len() as u64;
        column.packed = zstd::bulk::compress(&raw, 1)?;
    } else {
        change(&mut column.packed, &[], &[], random);
    }
    Ok(())
}

fn renumber(chunk: &mut Chunk, random: &mut Random) {
    let (Chunk::Payload(id, _) | Chunk::Tile(id, _)) = chunk;
    if random.once_in(2) {
        id.frame = random.below(4) as u32;
    } else {
        id.tile = random.below(4) as u32;
    }
}

fn take_apart(bytes: &[u8]) -> Result<Vec<Chunk>> {
    let reader = Reader::from_bytes(bytes.to_vec(), Limits::default())?;
    let mut chunks = Vec::new();
    for record in reader.chunks() {
        if record.id.kind != ChunkKind::TILE {
            let payload = reader.read(record)?;
            if payload.len() > 4 * mutate::LENGTH_MAX {
                return Err(anyhow!("too long"));
            }
            chunks.push(Chunk::Payload(record.id, payload));
            continue;
        }
        let directory = reader.tile_directory(record)?;
        let mut columns = Vec::new();
        for info in directory.columns() {
            let packed = reader.read_column(record, &directory, info.id)?.unwrap_or_default();
            columns.push(ColumnEntry { id: info.id, codec: info.codec, raw_len: info.raw_len, packed });
        }
        chunks.push(Chunk::Tile(record.id, columns));
    }
    Ok(chunks)
}

fn put_together(chunks: &[Chunk]) -> Result<Vec<u8>> {
    place::with(|place| {
        let path = place.path("forged.rtrace");
        Writer::discard(&path).ok();
        fs::remove_file(&path).ok();
        let mut writer = Writer::create(&path)?;
        for chunk in chunks {
            let encoded = match chunk {
                Chunk::Payload(id, payload) => EncodedChunk::new(*id, Encoding::Zstd(1), payload)?,
                Chunk::Tile(id, columns) => EncodedChunk::tile(*id, columns)?,
            };
            writer.write_encoded(&encoded)?;
        }
        writer.finish()?;
        Ok(fs::read(&path)?)
    })
}
