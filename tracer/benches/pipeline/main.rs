//! What recording costs and what a trace weighs.
//!
//! ```text
//! cargo bench -p rayreel-tracer --bench pipeline                    all scenes at 1024x512, 2x2 samples, depth 4
//! cargo bench -p rayreel-tracer --bench pipeline -- --codecs        also the plain codec at zstd levels 1, 3 and 9
//! cargo bench -p rayreel-tracer --bench pipeline -- --plain         plain tracing only
//! cargo bench -p rayreel-tracer --bench pipeline -- --size 512x256 --rounds 9 chess teapot
//! ```
//!
//! Scenes are the built-in ones and, where `../shared/scenes` is there, those of its `cameras.json`. Speeds are those of
//! one thread, by the processor time that all threads took: the best of several rounds of plain tracing, recording and
//! capture in turn, so the ratios hold on a busy machine. "plain" is tracing and shading without recording; "recorded"
//! adds paths in memory; "capture" adds coding, without the disk.

mod clock;
mod scenes;

use rayon::prelude::*;
use rayreel_formats::Limits;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec};
use rayreel_scenes::Scene;
use rayreel_tracer::{SampleGrid, TraceSettings, Tracer, build, convert};

struct Arguments {
    size: (u32, u32),
    codecs: bool,
    plain: bool,
    rounds: usize,
    scenes: Vec<String>,
}

fn arguments() -> Arguments {
    let mut parsed = Arguments { size: (1024, 512), codecs: false, plain: false, rounds: 4, scenes: Vec::new() };
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match argument.as_str() {
            "--bench" => {}
            "--codecs" => parsed.codecs = true,
            "--plain" => parsed.plain = true,
            "--size" => {
                let size = given.next().unwrap_or_default();
                let pair = size.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
                parsed.size = pair.expect("--size takes WxH");
            }
            "--rounds" => parsed.rounds = given.next().and_then(|r| r.parse().ok()).expect("--rounds takes a number"),
            name => parsed.scenes.push(name.to_string()),
        }
    }
    parsed
}

/// One frame of a scene, ready to be traced.
struct Frame<'a> {
    tracer: &'a Tracer<'a>,
    meta: &'a Meta,
    camera: Camera,
    codec: TileCodec<'a>,
}

impl Frame<'_> {
    fn tiles(&self) -> Vec<u32> {
        (0..self.meta.tile_count()).collect()
    }

    fn plain(&self) -> f64 {
        clock::spent(|| {
            self.tiles().par_iter().for_each(|&t| {
                std::hint::black_box(self.tracer.colours(&self.camera, self.meta.tile_rect(t)));
            });
        })
    }

    fn record(&self, tile: u32) -> Tile {
        self.tracer.tile::<true>(&self.camera, self.meta.tile_rect(tile), 0, tile)
    }

    fn recorded(&self) -> f64 {
        clock::spent(|| {
            self.tiles().par_iter().for_each(|&t| {
                std::hint::black_box(self.record(t));
            });
        })
    }

    fn capture(&self) -> f64 {
        clock::spent(|| {
            self.tiles().par_iter().for_each_init(Scratch::default, |scratch, &t| {
                std::hint::black_box(
                    self.codec.encode_traced(&self.record(t), Codec::Context, scratch).expect("tile codes"),
                );
            });
        })
    }

    /// Coded bytes by column, rays, steps.
    fn sizes(&self, codec: Codec) -> ([u64; 4], u64, u64) {
        let one = |scratch: &mut Scratch, &t: &u32| {
            let tile = self.record(t);
            let bytes = Column::ALL.map(|c| self.codec.column_bytes(&tile, c, codec, scratch).expect("codes") as u64);
            (bytes, tile.tree.ray_count(), tile.paths.steps.len() as u64)
        };
        let all: Vec<_> = self.tiles().par_iter().map_init(Scratch::default, one).collect();
        all.into_iter().fold(([0; 4], 0, 0), |sum, one| {
            (std::array::from_fn(|c| sum.0[c] + one.0[c]), sum.1 + one.1, sum.2 + one.2)
        })
    }
}

fn bench(name: &str, scene: &Scene, frame: usize, arguments: &Arguments) {
    let built = build(scene).expect("bvh");
    let (width, height) = arguments.size;
    let grid = SampleGrid { width, height, samples: 2, tile: 32, first_frame: 0, frames: 1 };
    let meta = grid.meta(scene, TraceSettings::default(), "bench");
    let tracer = Tracer::new(scene, &built, TraceSettings::default());
    let (columns, rows) = meta.grid();
    let camera = convert::camera(&scene.cameras[frame], columns, rows);
    let topology = BvhTopology::new(&built.bvh);
    let limits = Limits::default();
    let codec = TileCodec { meta: &meta, bvh: &built.bvh, topology: &topology, camera: &camera, limits: &limits };
    let frame = Frame { tracer: &tracer, meta: &meta, camera, codec };
    let bvh = built.bvh.to_payload().expect("bvh");
    let bvh = zstd::bulk::compress(&bvh, 9).expect("zstd").len() as f64;

    if arguments.plain {
        let rays: u64 = frame
            .tiles()
            .iter()
            .map(|&t| tracer.tile::<false>(&camera, meta.tile_rect(t), 0, t))
            .map(|t| t.tree.ray_count())
            .sum();
        let plain = (0..arguments.rounds).map(|_| frame.plain()).fold(f64::MAX, f64::min);
        println!("{name:<17} {rays:>9} {:>5} {:>7.2}", "", rays as f64 / plain / 1e6);
        return;
    }
    let (mut plain, mut recorded, mut capture) = (f64::MAX, f64::MAX, f64::MAX);
    for _ in 0..arguments.rounds {
        plain = plain.min(frame.plain());
        recorded = recorded.min(frame.recorded());
        capture = capture.min(frame.capture());
    }
    let (bytes, rays, steps) = frame.sizes(Codec::Context);
    let per_ray = |bytes: f64| bytes / rays as f64;
    let total = per_ray(bytes.iter().sum::<u64>() as f64 + bvh);
    let speed = rays as f64 / plain / 1e6;
    println!(
        "{name:<17} {:>9} {:>5.1} {speed:>7.2} {:>6.2} {:>6.2}  {:>6.3} {:>6.3} {:>8.3} {:>6.3} {:>6.3} {total:>6.3}",
        rays,
        steps as f64 / rays as f64,
        plain / recorded,
        plain / capture,
        per_ray(bytes[0] as f64),
        per_ray(bytes[1] as f64),
        per_ray(bytes[2] as f64),
        per_ray(bytes[3] as f64),
        per_ray(bvh),
    );
    if arguments.codecs {
        for level in [1, 3, 9] {
            let mut bytes = [0; 4];
            let seconds = clock::spent(|| (bytes, ..) = frame.sizes(Codec::Plain(level)));
            let [tree, hits, radiance, paths] = bytes.map(|b| per_ray(b as f64));
            let sum = tree + hits + radiance + paths + per_ray(bvh);
            println!(
                "  plain, zstd {level:<2}  {:>37.2}  {tree:>6.3} {hits:>6.3} {radiance:>8.3} {paths:>6.3} {:>6} {sum:>6.3}",
                plain / seconds,
                ""
            );
        }
    }
}

fn main() {
    let arguments = arguments();
    let (w, h) = arguments.size;
    println!("{w}x{h} pixels, 2x2 samples, depth 4, {} threads; bytes a ray", rayon::current_num_threads());
    println!("Mrays/s: plain tracing, one thread; rec, cap: recording's and capture's speed over it\n");
    println!(
        "{:<17} {:>9} {:>5} {:>7} {:>6} {:>6}  {:>6} {:>6} {:>8} {:>6} {:>6} {:>6}",
        "scene", "rays", "steps", "Mrays/s", "rec", "cap", "tree", "hits", "radiance", "paths", "bvh", "all"
    );
    for (name, frame, load) in scenes::all() {
        if arguments.scenes.is_empty() || arguments.scenes.contains(&name) {
            match load() {
                Ok(scene) => bench(&name, &scene, frame, &arguments),
                Err(error) => println!("{name}: left out, {error}"),
            }
        }
    }
}
