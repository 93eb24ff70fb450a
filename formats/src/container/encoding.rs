//! Packing and unpacking of payloads with zstd: same bytes every time, and never more memory than was agreed.

use std::io::{self, Read};

use super::chunk_header::{ENCODING_STORED, ENCODING_ZSTD};
use crate::error::{Error, Result};

/// How a payload is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// As it is.
    Stored,
    /// One zstd frame at this level, 1 to 22. The level is not recorded: it changes the packed bytes only.
    Zstd(i32),
}

impl Encoding {
    /// The code in the file.
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Stored => ENCODING_STORED,
            Self::Zstd(_) => ENCODING_ZSTD,
        }
    }
}

/// A decoder gets at least this window whatever the content: 8 MiB, which RFC 8878 asks every decoder to support.
const WINDOW_LOG_MIN: u32 = 23;
/// And never more than this: 128 MiB, the most that any level of zstd uses.
const WINDOW_LOG_MAX: u32 = 27;

/// First step of memory growth in bytes; small payloads need no second.
const STEP: usize = 1 << 20;

/// Packs `raw` into one zstd frame with its content size and without a checksum: the container has its own.
///
/// Runs on the calling thread only, because zstd's output depends on whether it uses workers.
///
/// # Errors
/// [`Error::Usage`] for a level outside 1 to 22; [`Error::Damaged`] if zstd itself fails.
pub(crate) fn compress(raw: &[u8], level: i32) -> Result<Vec<u8>> {
    if !(1..=22).contains(&level) {
        return Err(Error::usage(format!("zstd level {level} is outside 1 to 22")));
    }
    let pack = || -> io::Result<Vec<u8>> {
        let mut compressor = zstd::bulk::Compressor::new(level)?;
        compressor.include_checksum(false)?;
        compressor.include_contentsize(true)?;
        compressor.compress(raw)
    };
    pack().map_err(|error| Error::decode("zstd frame to write", error.to_string()))
}

/// Unpacks the one zstd frame in `packed`, which must give exactly `raw_len` bytes.
///
/// The caller has checked `raw_len` against its limit. Memory grows with the bytes that the frame really gives.
///
/// # Errors
/// A sentence on what is wrong with the frame.
pub(crate) fn decompress(packed: &[u8], raw_len: u64) -> Result<Vec<u8>, String> {
    let window_log = raw_len.max(1).next_power_of_two().trailing_zeros().clamp(WINDOW_LOG_MIN, WINDOW_LOG_MAX);
    let mut raw = Vec::with_capacity(usize::try_from(raw_len).unwrap_or(STEP).min(STEP));
    let mut unpack = || -> io::Result<bool> {
        let mut decoder = zstd::stream::read::Decoder::with_buffer(packed)?.single_frame();
        decoder.window_log_max(window_log)?;
        // One byte more than agreed shows a frame that is too long, and lets the decoder reach the end of the frame.
        decoder.by_ref().take(raw_len.saturating_add(1)).read_to_end(&mut raw)?;
        Ok(decoder.finish().is_empty())
    };
    let all_used = unpack().map_err(|error| {
        // No fault of the file: what is said of a file may be kept, as a row that cannot be computed is.
        if is_of_memory(&error) {
            std::alloc::handle_alloc_error(std::alloc::Layout::new::<[u8; STEP]>());
        }
        format!("zstd frame: {error}")
    })?;
    if raw.len() as u64 != raw_len {
        return Err(format!("zstd frame does not give the {raw_len} bytes that the header promises"));
    }
    if !all_used {
        return Err("bytes follow the zstd frame".to_owned());
    }
    Ok(raw)
}

/// Whether there was no memory. What zstd refuses of a frame, it calls memory that is required and not allocated.
fn is_of_memory(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::OutOfMemory || error.to_string().to_lowercase().contains("alloc")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lack_of_memory_is_told_from_a_bad_frame() {
        assert!(is_of_memory(&io::ErrorKind::OutOfMemory.into()));
        assert!(is_of_memory(&io::Error::other("zstd could not allocate a decompression context")));
        assert!(is_of_memory(&io::Error::other("Allocation error : not enough memory")));
        let frame = compress(&[7; 1000], 3).unwrap();
        for text in [decompress(&frame[..9], 1000), decompress(b"no frame", 1000)].map(Result::unwrap_err) {
            assert!(!is_of_memory(&io::Error::other(text)));
        }
        assert!(!is_of_memory(&io::Error::other("Frame requires too much memory for decoding")));
    }

    #[test]
    fn every_level_gives_the_bytes_back_and_the_same_frame_twice() {
        let raw: Vec<u8> = (0..50_000_u32).map(|i| ((i * i) >> 7) as u8).collect();
        for level in 1..=22 {
            let packed = compress(&raw, level).unwrap();
            assert_eq!(packed, compress(&raw, level).unwrap());
            assert_eq!(decompress(&packed, raw.len() as u64).unwrap(), raw);
        }
        assert!(compress(&raw, 0).is_err() && compress(&raw, 23).is_err());
    }

    #[test]
    fn a_frame_of_another_length_is_refused() {
        for len in [0_usize, 1, 1000] {
            let packed = compress(&vec![7; len], 3).unwrap();
            assert!(decompress(&packed, len as u64).is_ok());
            assert!(decompress(&packed, len as u64 + 1).is_err());
            if len > 0 {
                assert!(decompress(&packed, len as u64 - 1).is_err());
            }
            let mut longer = packed.clone();
            longer.push(0);
            assert!(decompress(&longer, len as u64).is_err());
            longer.pop();
            longer.extend_from_slice(&packed);
            assert!(decompress(&longer, len as u64).is_err(), "two frames are not one");
            longer.truncate(packed.len() - 1);
            assert!(decompress(&longer, len as u64).is_err());
        }
    }

    /// A frame header that asks for a window of 2^60 bytes is refused by its window, before zstd allocates it.
    #[test]
    fn a_huge_window_is_refused() {
        let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0xe0]; // 8-byte content size, single segment
        frame.extend_from_slice(&(1_u64 << 60).to_le_bytes());
        frame.extend_from_slice(&[1, 0, 0]);
        let error = decompress(&frame, 100).unwrap_err();
        assert!(error.contains("memory"), "{error}");
    }
}
