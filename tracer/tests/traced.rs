//! What capture knows of a tile that it has just traced is true: coded with that knowledge and without, the bytes are the
//! same.

mod support;

use rayreel_formats::Limits;
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec};
use rayreel_tracer::{TraceSettings, Tracer, build, convert};
use support::recorded::grid;
use support::{builtin, cutout};

#[test]
fn tiles_of_a_tracer_need_no_second_look() {
    for (scene, depth) in
        [(builtin("cornell"), 3), (builtin("teapot"), 4), (builtin("chess"), 4), (cutout::scene(3), 6)]
    {
        let built = build(&scene).expect("bvh");
        let settings = TraceSettings { max_depth: depth, ..TraceSettings::default() };
        let meta = grid(53, 31, 2, 32).meta(&scene, settings, "test");
        let (columns, rows) = meta.grid();
        let camera = convert::camera(&scene.cameras[0], columns, rows);
        let (topology, limits) = (BvhTopology::new(&built.bvh), Limits::default());
        let codec = TileCodec { meta: &meta, bvh: &built.bvh, topology: &topology, camera: &camera, limits: &limits };
        let (tracer, mut scratch) = (Tracer::new(&scene, &built, settings), Scratch::default());
        let mut weights = 0;
        for index in 0..meta.tile_count() {
            let tile = tracer.tile::<true>(&camera, meta.tile_rect(index), 0, index);
            weights += tile.tree.nodes.iter().filter(|n| n.reflect || n.refract).count();
            for codec_of in [Codec::Context, Codec::Plain(1)] {
                let known = codec.encode_traced(&tile, codec_of, &mut scratch).expect("it codes");
                let seen = codec.encode(&tile, codec_of, &mut scratch).expect("it codes");
                assert_eq!(known, seen, "{}, tile {index}, {codec_of:?}", scene.name);
            }
        }
        assert!(weights > 100, "{}: {weights} rays with children show little", scene.name);
    }
}
