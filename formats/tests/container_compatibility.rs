//! Files written by the version that introduced their format are read for ever. They are never written again: zstd's
//! next release may pack the same content into other bytes.

mod container_support;

use container_support::{read_all, sample_bytes};
use rayreel_formats::Limits;
use rayreel_formats::container::{FormatVersion, Reader};

#[test]
fn version_1_0_is_read() {
    let bytes = include_bytes!("container_golden/v1_0_container.rtrace").to_vec();
    let reader = Reader::from_bytes(bytes, Limits::default()).unwrap();
    assert_eq!(reader.version(), FormatVersion { major: 1, minor: 0 });
    let today = Reader::from_bytes(sample_bytes(), Limits::default()).unwrap();
    assert_eq!(read_all(&reader).unwrap(), read_all(&today).unwrap());
}
