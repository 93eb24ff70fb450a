//! Files whose fields lie, under checksums that hold.

use rayreel_formats::container::{CHUNK_HEADER_LEN, ChunkId, Reader, Source, scan_source};
use rayreel_formats::error::Fault;
use rayreel_formats::{Error, Limits, Result};

use super::{Content, patch, read_bytes, sample_bytes};

const HEADER: usize = CHUNK_HEADER_LEN as usize;

/// Where things lie in the sample, to forge them with right checksums.
pub struct Forge {
    pub bytes: Vec<u8>,
    /// Offset of the index chunk.
    pub index: usize,
    /// Offset of the first tile.
    pub tile: usize,
    /// Offset of the entry of the first tile in the unpacked index.
    pub tile_entry: usize,
}

impl Forge {
    pub fn new() -> Self {
        let bytes = sample_bytes();
        let trailer = bytes.len() - 32;
        let index = u64::from_le_bytes(bytes[trailer..trailer + 8].try_into().unwrap()) as usize;
        let reader = Reader::from_bytes(bytes.clone(), Limits::default()).unwrap();
        let at = reader.chunks().iter().position(|record| record.id == ChunkId::tile(0, 0)).unwrap();
        Self { bytes, index, tile: reader.chunks()[at].offset as usize, tile_entry: 16 + 48 * at }
    }

    pub fn trailer_field(mut self, at: usize, value: &[u8]) -> Self {
        let trailer = self.bytes.len() - 32;
        patch(&mut self.bytes, trailer + at, value, trailer, trailer + 24);
        self
    }

    /// A field of the header of the chunk at `chunk`.
    pub fn header_field(mut self, chunk: usize, at: usize, value: &[u8]) -> Self {
        patch(&mut self.bytes, chunk + at, value, chunk, chunk + HEADER - 4);
        self
    }

    /// A field of the unpacked index, which is packed again.
    pub fn index_field(mut self, at: usize, value: &[u8]) -> Self {
        let end = self.bytes.len() - 32;
        let mut raw = zstd::decode_all(&self.bytes[self.index + HEADER..end]).unwrap();
        raw[at..at + value.len()].copy_from_slice(value);
        let packed = zstd::bulk::compress(&raw, 3).unwrap();
        let trailer = self.bytes.split_off(end);
        self.bytes.truncate(self.index + HEADER);
        self.bytes.extend_from_slice(&packed);
        self.bytes.extend_from_slice(&trailer);
        let index = self.index;
        let total = (HEADER + packed.len()) as u64;
        self.header_field(index, 32, &(packed.len() as u64).to_le_bytes())
            .header_field(index, 40, &crc32fast::hash(&packed).to_le_bytes())
            .trailer_field(8, &total.to_le_bytes())
    }

    /// A field of the directory of the first tile, with all checksums above it.
    pub fn directory_field(mut self, at: usize, value: &[u8]) -> Self {
        let payload = self.tile + HEADER;
        let crc_at = payload + 4 + 3 * 24;
        patch(&mut self.bytes, payload + at, value, payload, crc_at);
        let end = crc_at + 4 + b"treehits hits".len();
        let crc = crc32fast::hash(&self.bytes[payload..end]).to_le_bytes();
        let (tile, entry) = (self.tile, self.tile_entry);
        self.header_field(tile, 40, &crc).index_field(entry + 40, &crc)
    }

    /// Scans the file, then reads everything in it.
    pub fn read(self) -> Result<Content> {
        let source = Box::new(Bytes(self.bytes.clone()));
        let _whatever_it_finds = scan_source(source, "forged".as_ref(), &Limits::default());
        read_bytes(&self.bytes)
    }

    pub fn error(self) -> Error {
        self.read().unwrap_err()
    }
}

#[derive(Debug)]
struct Bytes(Vec<u8>);

impl Source for Bytes {
    fn size(&self) -> std::io::Result<u64> {
        Ok(self.0.len() as u64)
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> std::io::Result<usize> {
        let rest = &self.0[(offset as usize).min(self.0.len())..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}

pub fn expect_corrupt(forge: Forge, part: &str) {
    let error = forge.error();
    assert!(
        matches!(error, Error::Damaged { fault: Fault::Content(_), .. }) && error.to_string().contains(part),
        "{error}"
    );
}

pub fn expect_limit(forge: Forge, part: &str) {
    let error = forge.error();
    assert!(matches!(error, Error::LimitExceeded { .. }) && error.to_string().contains(part), "{error}");
}
