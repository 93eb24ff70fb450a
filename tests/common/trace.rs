//! Traces through the library: to look into a file, and to write one that is subtly wrong.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::bvh::Bvh;
use rayreel_formats::container::{ChunkId, ColumnEntry, ColumnInfo, EncodedChunk};
use rayreel_formats::scene::Meta;
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec, Trace, TraceWriter};

/// Opens a trace.
#[track_caller]
pub fn open(file: &Path) -> Trace {
    Trace::open(file, Limits::default()).unwrap()
}

/// Writes `trace` to `file`, each tile changed by `change`.
pub fn rewrite(trace: &Trace, file: &Path, codec: Codec, change: impl FnMut(&mut Tile)) {
    rewrite_with(trace, file, codec, (trace.meta(), trace.bvh()), change);
}

/// The same with other metadata and tables.
pub fn rewrite_with(
    trace: &Trace,
    file: &Path,
    codec: Codec,
    (meta, bvh): (&Meta, &Bvh),
    mut change: impl FnMut(&mut Tile),
) {
    let limits = Limits::default();
    let topology = BvhTopology::new(bvh);
    let mut writer = TraceWriter::create(file, meta, bvh, 3).unwrap();
    for frame in meta.frame_numbers() {
        let camera = trace.camera(frame).unwrap();
        writer.frame(frame, &camera).unwrap();
        let coder = TileCodec { meta, bvh, topology: &topology, camera: &camera, limits: &limits };
        for index in 0..meta.tile_count() {
            let mut tile = trace.tile(frame, index, &Column::ALL).unwrap();
            change(&mut tile);
            writer.tile(&coder.encode(&tile, codec, &mut Scratch::default()).unwrap()).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Writes `trace` to `file` without a column of its tiles: as another writer may, who leaves out what its readers do not need.
pub fn without(trace: &Trace, file: &Path, left_out: Column) {
    let (meta, reader) = (trace.meta(), trace.reader());
    let mut writer = TraceWriter::create(file, meta, trace.bvh(), 3).unwrap();
    for frame in meta.frame_numbers() {
        writer.frame(frame, &trace.camera(frame).unwrap()).unwrap();
        for tile in 0..meta.tile_count() {
            let id = ChunkId::tile(frame, tile);
            let record = reader.find(id).unwrap();
            let directory = reader.tile_directory(record).unwrap();
            let entry = |column: &ColumnInfo| {
                let packed = reader.read_column(record, &directory, column.id).unwrap().unwrap();
                ColumnEntry { id: column.id, codec: column.codec, raw_len: column.raw_len, packed }
            };
            let kept = directory.columns().iter().filter(|column| column.id != left_out as u8);
            writer.tile(&EncodedChunk::tile(id, &kept.map(entry).collect::<Vec<_>>()).unwrap()).unwrap();
        }
    }
    writer.finish().unwrap();
}
