//! No memory is taken for a number that the input has not earned. Alone in its process, so that the measure is of this
//! only.

mod container_support;

use container_support::forge::{Forge, expect_corrupt, expect_limit};
use container_support::patch;

/// A length that no machine can give.
const HUGE: [u8; 8] = (1_u64 << 60).to_le_bytes();

/// The most address space this process ever had, touched or not, in bytes; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|kib| kib.parse::<u64>().ok()).unwrap_or(0) << 10
}

/// Every length in the file, forged to 2^60 (or 2^30 and 2^32 - 1 where it has no room) with right checksums.
#[test]
fn huge_lengths_are_refused_without_memory() {
    let before = peak_memory();
    assert!(before > 0 || cfg!(not(target_os = "linux")), "the system tells no VmPeak, and nothing is measured");
    let forge = Forge::new;
    let (index, tile, entry) = (forge().index, forge().tile, forge().tile_entry);

    expect_corrupt(forge().trailer_field(0, &HUGE), "trailer does not point");
    expect_corrupt(forge().trailer_field(8, &HUGE), "trailer does not point");
    expect_corrupt(forge().trailer_field(16, &HUGE), "more chunks than the file has room for");

    expect_limit(forge().header_field(index, 24, &HUGE), "raw length of a chunk");
    expect_corrupt(forge().header_field(index, 32, &HUGE), "not the index it describes");
    expect_corrupt(forge().index_field(0, &HUGE), "not as long as its counts say");
    expect_corrupt(forge().index_field(8, &HUGE), "not as long as its counts say");
    expect_corrupt(forge().index_field(entry + 16, &HUGE), "gap or overlaps");
    expect_corrupt(forge().index_field(entry + 24, &HUGE), "end behind the last one");
    expect_limit(forge().index_field(entry + 32, &HUGE), "raw length of a chunk");
    expect_corrupt(forge().index_field(entry + 44, &[0xff; 4]), "column directory");

    expect_corrupt(forge().header_field(tile, 24, &HUGE), "not what the index says");
    expect_corrupt(forge().header_field(tile, 32, &HUGE), "not what the index says");
    expect_limit(forge().header_field(tile, 24, &HUGE).index_field(entry + 32, &HUGE), "raw length of a chunk");
    let gibibyte = (1_u64 << 30).to_le_bytes();
    let meta = 32;
    expect_limit(forge().header_field(meta, 24, &gibibyte).index_field(16 + 32, &gibibyte), "raw length of a chunk");

    expect_limit(forge().directory_field(4 + 8, &HUGE), "packed length of a column");
    expect_limit(forge().directory_field(4 + 16, &HUGE), "raw length of a column");
    expect_corrupt(forge().directory_field(4 + 8, &gibibyte), "the columns end at byte");
    expect_limit(forge().directory_field(0, &[255]), "number of columns");

    let mut file = forge();
    patch(&mut file.bytes, 12, &u32::MAX.to_le_bytes(), 0, 28);
    expect_corrupt(file, "file header claims");
    assert!(peak_memory() - before < 64 << 20, "{} bytes", peak_memory() - before);
}
