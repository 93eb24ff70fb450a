//! The input is in the hands of an attacker. The contract: an error, or the content that was written; never a panic.
//! (Memory is watched in `container_memory.rs`.)

mod container_support;

use container_support::forge::{Forge, expect_corrupt};
use container_support::{read_bytes, sample, sample_bytes, write};
use proptest::prelude::*;
use rayreel_formats::container::{ChunkId, Reader};
use rayreel_formats::error::{Fault, Missing, Unknown};
use rayreel_formats::{Error, Limits};

#[test]
fn every_flipped_byte_is_noticed() {
    let whole = sample_bytes();
    read_bytes(&whole).unwrap();
    for at in 0..whole.len() {
        for flip in (0..8).map(|bit| 1 << bit).chain([0xff]) {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            let error = read_bytes(&bytes).expect_err(&format!("byte {at} ^ {flip:#x}"));
            assert!(!error.to_string().is_empty());
        }
    }
}

#[test]
fn every_truncation_is_noticed() {
    let whole = sample_bytes();
    for len in 0..whole.len() {
        let error = read_bytes(&whole[..len]).unwrap_err();
        match len {
            0 => assert!(matches!(error, Error::Unsupported { what: Unknown::File, .. })),
            1..32 => assert!(matches!(error, Error::Damaged { fault: Fault::Truncated { .. }, .. }), "{len}: {error}"),
            _ => assert!(matches!(error, Error::Incomplete { missing: Missing::Index, .. }), "{len}: {error}"),
        }
    }
    let mut longer = whole;
    longer.push(0);
    assert!(read_bytes(&longer).is_err());
}

#[test]
fn errors_say_where() {
    let (_folder, path) = write(&sample());
    let mut bytes = std::fs::read(&path).unwrap();
    let reader = Reader::open(&path, Limits::default()).unwrap();
    let record = *reader.find(ChunkId::tile(0, 1)).unwrap();
    let last = record.end() as usize - 1;
    bytes[last] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let error = Reader::open(&path, Limits::default()).unwrap().read(&record).unwrap_err().to_string();
    let start = format!("{}, byte {}, frame 0, tile 1: checksum of the chunk payload", path.display(), record.offset);
    assert!(error.starts_with(&start), "{error}");
    let directory = reader.tile_directory(&record).unwrap();
    let error = reader.read_column(&record, &directory, 7).unwrap_err();
    assert!(error.to_string().contains("checksum of the column 7 does not hold"), "{error}");
    assert!(reader.read_column(&record, &directory, 2).is_ok(), "the other column is still good");
}

#[test]
fn forged_content_is_refused() {
    let forge = Forge::new;
    let (tile, entry) = (forge().tile, forge().tile_entry);
    expect_corrupt(forge().index_field(entry, b"INDX"), "lists an index");
    expect_corrupt(forge().index_field(entry, b"META"), "do not fit the kind");
    expect_corrupt(forge().index_field(entry + 8, &1_u32.to_le_bytes()), "second TILE chunk of frame 0, tile 1");
    expect_corrupt(forge().directory_field(4, &[9]), "do not ascend");
    let unknown = forge().header_field(tile, 16, &[9]).index_field(entry + 12, &[9]).error();
    assert!(matches!(unknown, Error::Unsupported { what: Unknown::Encoding(9), .. }), "{unknown}");
    let totals = 16 + 48 * 9 + 8 + 8;
    expect_corrupt(forge().index_field(totals, &[0xee]), "do not add up");
}

#[test]
fn limits_bind() {
    let with = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        let reader = Reader::from_bytes(sample_bytes(), limits)?;
        container_support::read_all(&reader)
    };
    assert!(with(|_| ()).is_ok());
    for change in [
        (|limits| limits.max_chunk_packed_bytes = 60) as fn(&mut Limits),
        |limits| limits.max_chunk_raw_bytes = 299,
        |limits| limits.max_index_entries = 8,
        |limits| limits.max_columns_per_tile = 2,
    ] {
        assert!(matches!(with(change), Err(Error::LimitExceeded { .. })));
    }
}

/// Fields worth lying with: small, at the edges of their types, and anything.
fn any_field() -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![0..200_u64, (0..64_u32).prop_map(|bit| 1 << bit), Just(u64::MAX), any::<u64>()];
    (word, prop_oneof![Just(1_usize), Just(4), Just(8)]).prop_map(|(word, len)| word.to_le_bytes()[..len].to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 400, ..ProptestConfig::default() })]

    /// Checksums are no defence against an attacker: with all of them right, a lie is still refused or harmless.
    #[test]
    fn lies_never_panic(
        index in prop::collection::vec((0..528_usize, any_field()), 0..3),
        directory in prop::option::of((0..69_usize, any_field())),
        header in prop::option::of((4..37_usize, any_field())),
        trailer in prop::option::of((0..17_usize, any_field())),
    ) {
        let mut forge = Forge::new();
        if let Some((at, value)) = directory {
            forge = forge.directory_field(at, &value);
        }
        if let Some((at, value)) = header {
            let tile = forge.tile;
            forge = forge.header_field(tile, at, &value);
        }
        for (at, value) in index {
            forge = forge.index_field(at, &value);
        }
        if let Some((at, value)) = trailer {
            forge = forge.trailer_field(at, &value);
        }
        let _ = forge.read();
    }
}
