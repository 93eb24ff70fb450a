//! A killed capture is continued to the same file, byte for byte, wherever it was cut.

mod container_support;

use std::fs;
use std::path::Path;

use container_support::{NOTE, partial, patch, sample, sample_bytes};
use rayreel_formats::container::{ChunkId, EncodedChunk, Writer};
use rayreel_formats::error::Unknown;
use rayreel_formats::{Error, Limits};

/// Leaves `bytes` as the partial file of `path`, resumes it, writes what is missing, and gives the finished file.
fn resume(path: &Path, bytes: &[u8], chunks: &[EncodedChunk]) -> Vec<u8> {
    fs::write(partial(path), bytes).unwrap();
    let resumed = Writer::resume(path, &Limits::default()).unwrap().unwrap();
    let there = resumed.chunks().to_vec();
    for (record, chunk) in there.iter().zip(chunks) {
        assert_eq!(record.id, chunk.id());
        resumed.read(record).unwrap();
    }
    if there.len() > 3 {
        let directory = resumed.tile_directory(&there[3]).unwrap();
        assert_eq!(resumed.read_column(&there[3], &directory, 1).unwrap().unwrap(), b"tree");
        assert_eq!(resumed.read_tile(&there[3]).unwrap().directory, directory);
    }
    assert_eq!(resumed.kept_bytes() + resumed.dropped_bytes(), bytes.len() as u64);
    assert!(fs::read(partial(path)).unwrap() == bytes, "nothing changes before it is said to go on");
    let mut writer = resumed.go_on().unwrap();
    for chunk in &chunks[there.len()..] {
        writer.write_encoded(chunk).unwrap();
    }
    writer.finish().unwrap();
    fs::read(path).unwrap()
}

#[test]
fn resuming_after_a_cut_at_any_byte_gives_the_same_file() {
    let (chunks, whole) = (sample(), sample_bytes());
    let folder = container_support::folder();
    let path = folder.path().join("t");
    for cut in 0..=whole.len() {
        assert!(resume(&path, &whole[..cut], &chunks) == whole, "cut at {cut}");
        assert!(!partial(&path).exists());
    }
}

/// A power cut may leave zeros or noise where the last chunks should be.
#[test]
fn resuming_after_a_damaged_byte_gives_the_same_file() {
    let (chunks, whole) = (sample(), sample_bytes());
    let folder = container_support::folder();
    let path = folder.path().join("t");
    for at in 32..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        assert!(resume(&path, &bytes, &chunks) == whole, "damaged at {at}");
    }
}

#[test]
fn nothing_to_resume() {
    let folder = container_support::folder();
    assert!(Writer::resume(&folder.path().join("t"), &Limits::default()).unwrap().is_none());
}

#[test]
fn what_is_not_ours_is_not_touched() {
    let folder = container_support::folder();
    let path = folder.path().join("t");
    let mut newer = sample_bytes();
    patch(&mut newer, 10, &1_u16.to_le_bytes(), 0, 28);
    for bytes in [b"something else".to_vec(), newer] {
        fs::write(partial(&path), &bytes).unwrap();
        let error = Writer::resume(&path, &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Unsupported { what: Unknown::File | Unknown::Version { .. }, .. }), "{error}");
        assert_eq!(fs::read(partial(&path)).unwrap(), bytes);
    }
}

#[test]
fn a_resumed_writer_knows_its_chunks() {
    let folder = container_support::folder();
    let path = folder.path().join("t");
    fs::write(partial(&path), sample_bytes()).unwrap();
    let mut writer = Writer::resume(&path, &Limits::default()).unwrap().unwrap().go_on().unwrap();
    assert!(writer.contains(ChunkId::tile(1, 0)) && writer.contains(NOTE));
    assert!(!writer.contains(ChunkId::tile(1, 1)));
    assert!(matches!(writer.write_encoded(&sample()[0]), Err(Error::Usage { .. })));
}
