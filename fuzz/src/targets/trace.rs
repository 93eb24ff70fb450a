//! Traces, and what is in them.

use rayreel_formats::bvh::Bvh;
use rayreel_formats::container::{ChunkId, Reader, scan_source};
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Codec, Scratch};
use rayreel_formats::{Limits, Trace};

use crate::random::Random;
use crate::seeds;
use crate::target::{Target, told};
use crate::traces::{Parts, change_trace};

pub fn targets() -> Vec<Target> {
    let whole: fn(&mut Vec<u8>, &mut Random) = |bytes, random| change_trace(bytes, Parts::All, random);
    let columns: fn(&mut Vec<u8>, &mut Random) = |bytes, random| change_trace(bytes, Parts::Columns, random);
    let target = |name, seeds, read, change| Target { name, seeds, read, change, mend: None };
    vec![
        target("trace", both, read_trace, Some(whole)),
        target("trace-file", both, read_file, None),
        target("columns-context", || vec![seeds::trace(Codec::Context)], read_trace, Some(columns)),
        target("columns-plain", || vec![seeds::trace(Codec::Plain(1))], read_trace, Some(columns)),
        target("bvh", bvh_seeds, |bytes| told(&Bvh::from_payload(bytes, &Limits::default())), None),
        target("metadata", meta_seeds, read_metadata, None),
    ]
}

fn both() -> Vec<Vec<u8>> {
    vec![seeds::trace(Codec::Context), seeds::trace(Codec::Plain(1))]
}

fn chunk(id: ChunkId) -> Vec<u8> {
    let reader = Reader::from_bytes(seeds::trace(Codec::Context), Limits::default()).expect("a sound trace");
    let record = *reader.require(id).expect("it is there");
    reader.read(&record).expect("a sound chunk")
}

fn bvh_seeds() -> Vec<Vec<u8>> {
    vec![chunk(ChunkId::BVH)]
}

fn meta_seeds() -> Vec<Vec<u8>> {
    vec![chunk(ChunkId::META), chunk(ChunkId::frame(0))]
}

fn read_metadata(bytes: &[u8]) -> String {
    let limits = Limits::default();
    told(&Meta::from_payload(bytes, &limits)) + &told(&Camera::from_payload(bytes, &limits))
}

/// Everything that a reader can be asked for: tiles, rays, paths. Of pictures that claim millions of tiles, the first few.
fn read_trace(bytes: &[u8]) -> String {
    let trace = match Trace::from_bytes(bytes.to_vec(), Limits::default()) {
        Ok(trace) => trace,
        Err(error) => return told::<(), _>(&Err(error)),
    };
    let mut scratch = Scratch::default();
    let mut said = format!("opened, {} columns lacking", trace.lacking().len());
    let missing = trace.missing_tiles().len();
    for frame in trace.meta().frame_numbers().take(4) {
        for tile in 0..trace.meta().tile_count().min(4) {
            let read = trace.tile_with(frame, tile, &Column::ALL, &mut scratch);
            said = said + ", " + &told(&read);
            if let Ok(packed) = trace.packed_tile(frame, tile) {
                drop(trace.paths(&packed.0, &packed.1, &mut scratch));
            }
            match trace.rays(frame, tile) {
                Ok(rays) => said += if rays.into_iter().count() > 0 { "r" } else { "-" },
                Err(error) => assert!(read.is_err(), "a tile can be read and its rays cannot: {error}"),
            }
        }
    }
    if missing > 0 { said + " missing" } else { said }
}

/// The file as bytes: opening it, and what a repair would find.
fn read_file(bytes: &[u8]) -> String {
    let limits = Limits::default();
    let scanned = scan_source(Box::new(Bytes(bytes.to_vec())), "a.rtrace".as_ref(), &limits);
    let opened = Reader::from_bytes(bytes.to_vec(), limits);
    let whole = scanned.as_ref().is_ok_and(rayreel_formats::container::Scan::is_whole);
    format!("{} {} {whole}", told(&opened), told(&scanned))
}

#[derive(Debug)]
struct Bytes(Vec<u8>);

impl rayreel_formats::container::Source for Bytes {
    fn size(&self) -> std::io::Result<u64> {
        Ok(self.0.len() as u64)
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> std::io::Result<usize> {
        let rest = usize::try_from(offset).ok().and_then(|at| self.0.get(at..)).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}
