//! What is written is read back; the rules of writer and reader.

mod container_support;

use std::fs;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use container_support::{NOTE, column, partial, patch, read_all, read_bytes, sample, sample_bytes, write};
use proptest::prelude::*;
use rayreel_formats::container::{
    CHUNK_HEADER_LEN, ChunkId, ColumnEntry, EncodedChunk, Encoding, FormatVersion, Reader, Source, TileDirectory,
    Writer,
};
use rayreel_formats::error::{Fault, Missing, Occupant};
use rayreel_formats::{Error, Limits};

#[test]
fn the_sample_comes_back() {
    let (_folder, path) = write(&sample());
    let reader = Reader::open(&path, Limits::default()).unwrap();
    assert_eq!(reader.version(), FormatVersion::CURRENT);
    assert_eq!(reader.path(), path);
    let content = read_all(&reader).unwrap();
    assert_eq!(content.payloads.len(), 9);
    assert_eq!(content.payloads[1], (ChunkId::BVH, vec![5; 300]));
    assert_eq!(content.columns[0].1[1], (2, 2, 18, b"hits hits".to_vec()));
    assert_eq!(content.columns[1].1.iter().map(|column| column.0).collect::<Vec<_>>(), [2, 7], "sorted by id");
    let totals: Vec<_> = content.totals.iter().map(|t| (t.id, t.tiles, t.packed_bytes, t.raw_bytes)).collect();
    assert_eq!(totals, [(1, 1, 4, 8), (2, 2, 10, 20), (7, 2, 4, 8)]);
    assert!(!partial(&path).exists());
}

#[test]
fn chunks_are_found_by_id() {
    let reader = Reader::from_bytes(sample_bytes(), Limits::default()).unwrap();
    for record in reader.chunks() {
        assert_eq!(reader.find(record.id).unwrap().id, record.id);
    }
    let first_note = reader.chunks().iter().find(|record| record.id == NOTE);
    assert_eq!(reader.find(NOTE), first_note, "unknown kinds may repeat");
    assert!(reader.find(ChunkId::tile(1, 1)).is_none());
    let error = reader.require(ChunkId::tile(1, 1)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "<memory> holds no TILE chunk of frame 1, tile 1; `rayreel info` tells what it holds"
    );
}

#[test]
fn the_same_chunks_give_the_same_bytes() {
    assert_eq!(sample_bytes(), sample_bytes());
}

#[test]
fn an_empty_trace_is_a_trace() {
    let (_folder, path) = write(&[]);
    assert!(Reader::open(&path, Limits::default()).unwrap().chunks().is_empty());
}

#[test]
fn the_writer_keeps_its_rules() {
    let folder = container_support::folder();
    assert!(matches!(Writer::create(&folder.path().join("no/such/t")), Err(Error::Io { .. })));
    assert!(matches!(Writer::create(Path::new("..")), Err(Error::Usage { .. })));
    let path = folder.path().join("t");
    fs::write(&path, b"old").unwrap();
    let mut writer = Writer::create(&path).unwrap();
    writer.write(ChunkId::META, Encoding::Stored, b"1").unwrap();
    assert!(matches!(writer.write(ChunkId::META, Encoding::Stored, b"2"), Err(Error::Usage { .. })));
    for id in [ChunkId::tile(0, 0), ChunkId { frame: 3, ..ChunkId::META }, ChunkId { tile: 0, ..ChunkId::frame(3) }] {
        assert!(matches!(writer.write(id, Encoding::Stored, b""), Err(Error::Usage { .. })), "{id}");
    }
    assert_eq!(fs::read(&path).unwrap(), b"old", "the old file stays until the new one is complete");
    writer.finish().unwrap();
    assert_eq!(read_all(&Reader::open(&path, Limits::default()).unwrap()).unwrap().payloads.len(), 1);
}

#[test]
fn a_partial_file_is_not_overwritten() {
    let folder = container_support::folder();
    let path = folder.path().join("t");
    let writer = Writer::create(&path).unwrap();
    if cfg!(unix) {
        assert!(matches!(Writer::create(&path), Err(Error::Occupied { by: Occupant::Writer { .. }, .. })));
        assert!(matches!(Writer::discard(&path), Err(Error::Occupied { by: Occupant::Writer { .. }, .. })));
        assert!(matches!(
            Writer::resume(&path, &Limits::default()),
            Err(Error::Occupied { by: Occupant::Writer { .. }, .. })
        ));
    }
    drop(writer);
    assert!(partial(&path).exists());
    assert!(matches!(Writer::create(&path), Err(Error::Occupied { by: Occupant::File { .. }, .. })));
    assert!(matches!(
        Reader::open(&partial(&path), Limits::default()),
        Err(Error::Incomplete { missing: Missing::Index, .. })
    ));
    Writer::discard(&path).unwrap();
    Writer::discard(&path).unwrap();
    Writer::create(&path).unwrap();
}

#[test]
fn tiles_refuse_what_they_cannot_hold() {
    let twice = [column(3, b"a"), column(3, b"b")];
    assert!(matches!(EncodedChunk::tile(ChunkId::tile(0, 0), &twice), Err(Error::Usage { .. })));
    assert!(matches!(EncodedChunk::tile(ChunkId::META, &[]), Err(Error::Usage { .. })));
    let many: Vec<ColumnEntry> = (0..33).map(|id| column(id, b"")).collect();
    let (_folder, path) = write(&[EncodedChunk::tile(ChunkId::tile(0, 0), &many).unwrap()]);
    let reader = Reader::open(&path, Limits::default()).unwrap();
    assert!(matches!(reader.tile_directory(&reader.chunks()[0]), Err(Error::LimitExceeded { .. })));
}

#[test]
fn a_newer_minor_version_is_read_and_a_newer_major_version_is_not() {
    let mut bytes = sample_bytes();
    let content = read_bytes(&bytes).unwrap();
    patch(&mut bytes, 10, &7_u16.to_le_bytes(), 0, 28);
    let reader = Reader::from_bytes(bytes.clone(), Limits::default()).unwrap();
    assert_eq!(reader.version(), FormatVersion { major: 1, minor: 7 });
    assert_eq!(read_all(&reader).unwrap(), content);
    patch(&mut bytes, 8, &2_u16.to_le_bytes(), 0, 28);
    let error = Reader::from_bytes(bytes, Limits::default()).unwrap_err();
    assert!(error.to_string().contains("format version 2.7, this build knows 1.0"), "{error}");
}

/// A newer minor version may put more into the file header: its length says where the chunks start.
#[test]
fn a_longer_file_header_of_a_newer_minor_version_is_skipped() {
    let (_folder, path) = write(&[]);
    let old = fs::read(&path).unwrap();
    let build = |minor: u16| {
        let mut bytes = old[..32].to_vec();
        patch(&mut bytes, 10, &minor.to_le_bytes(), 0, 28);
        patch(&mut bytes, 12, &40_u32.to_le_bytes(), 0, 28);
        bytes.extend_from_slice(&[0xaa; 8]);
        bytes.extend_from_slice(&old[32..]);
        let trailer = bytes.len() - 32;
        patch(&mut bytes, trailer, &40_u64.to_le_bytes(), trailer, trailer + 24);
        Reader::from_bytes(bytes, Limits::default())
    };
    assert!(build(1).unwrap().chunks().is_empty());
    assert!(matches!(build(0), Err(Error::Damaged { fault: Fault::Content(_), .. })));
}

#[derive(Debug)]
struct Counting {
    bytes: Vec<u8>,
    read: Arc<AtomicU64>,
}

impl Source for Counting {
    fn size(&self) -> io::Result<u64> {
        Ok(self.bytes.len() as u64)
    }

    /// At most 10 bytes at a time, as a slow pipe would.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let rest = &self.bytes[(offset as usize).min(self.bytes.len())..];
        let count = rest.len().min(buffer.len()).min(10);
        buffer[..count].copy_from_slice(&rest[..count]);
        self.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

#[test]
fn random_access_reads_only_what_was_asked_for() {
    let big = vec![1; 100_000];
    let columns = [column(0, &big), column(1, b"wanted"), column(2, &big)];
    let chunks = [
        EncodedChunk::new(ChunkId::BVH, Encoding::Stored, &big).unwrap(),
        EncodedChunk::tile(ChunkId::tile(4, 2), &columns).unwrap(),
    ];
    let (_folder, path) = write(&chunks);
    let read = Arc::new(AtomicU64::new(0));
    let source = Counting { bytes: fs::read(path).unwrap(), read: Arc::clone(&read) };
    let taken = || read.swap(0, Ordering::Relaxed);
    let reader = Reader::from_source(Box::new(source), Path::new("counted"), Limits::default()).unwrap();
    assert!(taken() < 500, "header, trailer, index");
    let record = reader.find(ChunkId::tile(4, 2)).unwrap();
    let directory = reader.tile_directory(record).unwrap();
    assert_eq!(taken(), CHUNK_HEADER_LEN + u64::from(record.directory_len));
    assert_eq!(reader.read_column(record, &directory, 1).unwrap().unwrap(), b"wanted");
    assert_eq!(taken(), 6);
    assert_eq!(reader.read_column(record, &directory, 9).unwrap(), None);
    assert_eq!(taken(), 0);
    reader.read(record).unwrap();
    assert_eq!(taken(), record.total_len());
}

#[test]
fn records_from_elsewhere_are_refused() {
    let reader = Reader::from_bytes(sample_bytes(), Limits::default()).unwrap();
    let tile = *reader.find(ChunkId::tile(0, 0)).unwrap();
    let directory = reader.tile_directory(&tile).unwrap();
    for offset in [0, 1, tile.offset + 1, reader.len(), u64::MAX - 3, u64::MAX] {
        let wild = rayreel_formats::container::ChunkRecord { offset, ..tile };
        assert!(reader.read(&wild).is_err());
        assert!(reader.tile_directory(&wild).is_err());
        let _ = reader.read_column(&wild, &directory, 2);
    }
    let empty = *reader.find(ChunkId::tile(1, 0)).unwrap();
    assert!(matches!(reader.read_column(&empty, &directory, 2), Err(Error::Usage { .. })));
    assert!(matches!(reader.tile_directory(&reader.chunks()[0]), Err(Error::Usage { .. })));
}

fn any_column() -> impl Strategy<Value = (u8, u64, Vec<u8>)> {
    (any::<u8>(), 0..1000_u64, prop::collection::vec(any::<u8>(), 0..200))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn payloads_round_trip(payloads in prop::collection::vec((0..23_i32, prop::collection::vec(any::<u8>(), 0..3000)), 0..8)) {
        let chunks: Vec<_> = payloads.iter().enumerate().map(|(at, (level, payload))| {
            let encoding = if *level == 0 { Encoding::Stored } else { Encoding::Zstd(*level) };
            EncodedChunk::new(ChunkId::frame(at as u32), encoding, payload).unwrap()
        }).collect();
        let (_folder, path) = write(&chunks);
        let reader = Reader::open(&path, Limits::default()).unwrap();
        for (at, (_, payload)) in payloads.iter().enumerate() {
            prop_assert_eq!(&reader.read(reader.require(ChunkId::frame(at as u32)).unwrap()).unwrap(), payload);
        }
    }

    #[test]
    fn columns_round_trip(columns in prop::collection::vec(any_column(), 0..32)) {
        let mut columns: Vec<ColumnEntry> = columns.into_iter()
            .map(|(id, raw_len, packed)| ColumnEntry { id, codec: id ^ 0x5a, raw_len, packed }).collect();
        columns.sort_by_key(|column| column.id);
        columns.dedup_by_key(|column| column.id);
        let (_folder, path) = write(&[EncodedChunk::tile(ChunkId::tile(0, 0), &columns).unwrap()]);
        let content = read_all(&Reader::open(&path, Limits::default()).unwrap()).unwrap();
        let expected: Vec<_> = columns.into_iter().map(|c| (c.id, c.codec, c.raw_len, c.packed)).collect();
        prop_assert_eq!(&content.columns[0].1, &expected);
    }

    #[test]
    fn noise_never_panics(noise in prop::collection::vec(any::<u8>(), 0..400)) {
        let place = rayreel_formats::error::Place::unknown();
        let _ = TileDirectory::parse(&noise, noise.len() as u64, &place, &Limits::default());
        prop_assert!(Reader::from_bytes(noise.clone(), Limits::default()).is_err());
        let mut bytes = sample_bytes();
        bytes.truncate(32);
        bytes.extend_from_slice(&noise);
        prop_assert!(Reader::from_bytes(bytes, Limits::default()).is_err());
    }
}
