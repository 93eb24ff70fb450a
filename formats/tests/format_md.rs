//! What FORMAT.md says is what this crate does: `format_reader.py` follows the text chapter by chapter, shares no code
//! with the crate, and must find in every trace what the crate finds.
//!
//! Skipped where there is no python3, or none that can decompress zstd.

mod trace_support;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayreel_formats::Limits;
use rayreel_formats::bvh::{Bvh, Triangle, Vertex};
use rayreel_formats::container::ColumnEntry;
use rayreel_formats::half::Half3;
use rayreel_formats::intersect::intersect;
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::oct::Oct;
use rayreel_formats::rays::{self, Ray};
use rayreel_formats::scene::{Camera, Material, Optics};
use rayreel_formats::tile::{Hit, Tile};
use rayreel_formats::trace::{Codec, Trace, digest};
use trace_support::forge::{Chunk, put_together, take_apart};
use trace_support::whole::{Content, folder};

/// What the reader says when Python has no zstd.
const NO_ZSTD: i32 = 77;

/// What the reader prints as the digest of a trace, or its complaint; `None` where it cannot run.
fn python_digest(path: &Path) -> Option<Result<String, String>> {
    let reader = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/format_reader.py");
    let output = match Command::new("python3").arg("-B").arg(reader).arg(path).arg("--digest").output() {
        Ok(output) => output,
        Err(error) => {
            eprintln!("skipped: python3 does not start: {error}");
            return None;
        }
    };
    let text = |bytes| String::from_utf8(bytes).expect("the reader prints text");
    let errors = text(output.stderr);
    if output.status.code() == Some(NO_ZSTD) {
        eprintln!("skipped: {}", errors.trim());
        return None;
    }
    Some(if output.status.success() { Ok(text(output.stdout)) } else { Err(errors) })
}

/// True when the reader could run; it then found the same.
fn reads_alike(path: &Path) -> bool {
    let Some(found) = python_digest(path) else { return false };
    let found = found.unwrap_or_else(|e| panic!("the reader fails on {}: {e}", path.display()));
    let trace = Trace::open(path, Limits::default()).expect("this crate reads its own trace");
    let digest = digest(&trace).expect("the trace is whole");
    let mut expected: String = digest.parts().iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect();
    expected += &format!("{}  total\n", digest.total());
    assert_eq!(found, expected, "{}", path.display());
    true
}

#[test]
fn golden_traces() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: there is no {}", folder.display());
        return;
    };
    let mut traces: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be read").path()).collect();
    traces.retain(|path| path.extension().is_some_and(|e| e == "rtrace"));
    traces.sort();
    for path in traces {
        if !reads_alike(&path) {
            return;
        }
    }
}

/// Made-up tiles have what no tracer writes: cut-outs and dielectrics side by side, refractions where there are none,
/// any `t` and normal, and hardly anything as predicted.
#[test]
fn made_up_traces_of_either_codec_and_of_both() {
    // Seed, size, tile edge, triangles, depth, lights.
    let cases = [
        (1, (9, 7), 4, 40, 3, 2),
        (2, (12, 8), 8, 300, 1, 16),
        (3, (5, 5), 16, 0, 2, 1),
        (4, (20, 1), 7, 3, 14, 0),
        (5, (1, 20), 5, 5, 0, 3),
        (6, (24, 24), 12, 1000, 4, 1),
    ];
    for (seed, size, tile, triangles, depth, lights) in cases {
        let content = Content::random(seed, size, tile, triangles, depth, lights);
        for choice in [0, 1, 2] {
            // Plain, context, one and the other.
            let plain = |tile: &Tile| choice == 0 || choice == 2 && tile.index.is_multiple_of(2);
            let (_folder, path) = content.write(|tile| if plain(tile) { Codec::Plain(1) } else { Codec::Context });
            if !reads_alike(&path) {
                return;
            }
        }
    }
}

/// More paths in a tile than there are path numbers, so that the labels are forgotten on the way.
#[test]
fn more_paths_than_numbers() {
    let content = Content::random(7, (110, 110), 110, 6, 0, 2);
    let (_folder, path) = content.write(|_| Codec::Context);
    reads_alike(&path);
}

/// Where vertex normals cancel out, the face normal is predicted.
#[test]
fn normals_that_cancel_out() {
    let mut content = Content::random(8, (4, 4), 4, 1, 0, 1);
    let (up, down) = (Oct::encode(vec3(0.0, 0.0, 1.0)), Oct::encode(vec3(0.0, 0.0, -1.0)));
    let vertex = |x, y, normal| Vertex { position: vec3(x, y, 0.0), normal };
    let vertices = vec![vertex(0.0, 0.0, up), vertex(1.0, 0.0, down), vertex(0.0, 1.0, down)];
    // Of the same material: the paths say where a ray passes.
    let triangle = Triangle { vertices: [0, 1, 2], ..content.bvh.triangles[0] };
    let Bvh { objects, materials, .. } = content.bvh.clone();
    content.bvh = Bvh::new(&content.bvh.shape(), vec![triangle], vertices, objects, materials).expect("a tree");
    // All rays meet the triangle where the two outer corners weigh as much as the first.
    let zero = vec3(0.0, 0.0, 0.0);
    let camera = Camera { eye: vec3(0.25, 0.25, 2.0), corner: vec3(0.0, 0.0, -1.0), right: zero, down: zero };
    content.cameras.fill(camera);
    let normal = content.bvh.shading_normal(0, 0.25, 0.25);
    assert_eq!(normal, up, "the face looks up");
    for tile in &mut content.tiles {
        for (node, hit) in tile.tree.nodes.iter().zip(&mut tile.hits) {
            *hit = if node.hit { Hit { triangle: 0, t: 2.0, normal } } else { Hit::MISS };
        }
    }
    let (_folder, path) = content.write(|_| Codec::Context);
    reads_alike(&path);
}

/// Unknown columns are left alone; an unknown codec is an error.
#[test]
fn columns_and_codecs_to_come() {
    let bytes = Content::random(9, (6, 6), 6, 20, 2, 1).bytes(|_| Codec::Context);
    let folder = folder();
    let write = |name: &str, change: fn(&mut Vec<ColumnEntry>)| {
        let mut chunks = take_apart(&bytes);
        for chunk in &mut chunks {
            if let Chunk::Tile(_, columns) = chunk {
                change(columns);
            }
        }
        let path = folder.path().join(name);
        std::fs::write(&path, put_together(&chunks)).expect("the file can be written");
        path
    };
    let newer = write("column.rtrace", |columns| {
        columns.push(ColumnEntry { id: 200, codec: 77, raw_len: 9, packed: b"new".to_vec() });
    });
    if !reads_alike(&newer) {
        return;
    }
    let unknown = write("codec.rtrace", |columns| columns[3].codec = 2);
    let complaint = python_digest(&unknown).expect("the reader ran just before").expect_err("codec 2 is unknown");
    assert!(complaint.contains("codec 2"), "{complaint}");
    let trace = Trace::open(&unknown, Limits::default()).expect("a trace whose tiles are not read");
    assert!(digest(&trace).is_err());
}

/// The table of check values in the text is what this crate computes. (Its last row, a range-coded stream, is tested
/// beside the coder.)
#[test]
fn check_values() {
    let words = |words: &[f32]| -> String {
        words.iter().map(|w| format!("{:08X}", w.to_bits())).collect::<Vec<_>>().join(" ")
    };
    let halves = |h: Half3| h.0.map(|h| format!("{h:04X}")).join(" ");
    let vector = |v: Vec3| words(&v.to_array());
    let code = Oct::encode(vec3(1.0, 2.0, -3.0));
    let direction = vec3(0.1, 0.2, -1.0).normalized();
    let ray = Ray { origin: vec3(0.1, 0.2, 3.0), direction, t_max: f32::MAX };
    let corners = [vec3(0.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0)];
    let hit = intersect(&ray, corners, f32::INFINITY).expect("the ray meets the triangle");
    let surface = rays::surface(&ray, hit.t, corners, Oct::encode(vec3(0.1, 0.0, 1.0)));
    let reflection = rays::reflection(&surface, direction);
    let refraction = rays::refraction(&surface, direction, 1.5).expect("the ray enters");
    let glass = Material {
        name: String::new(),
        optics: Optics::Dielectric,
        ior: 1.5,
        specular: Vec3::ONE,
        transmission: vec3(1.0, 0.5, 0.25),
        cutout: false,
    };
    let weights = rays::children(&surface, direction, &glass);
    let (reflect, refract) = (weights.reflect.expect("it reflects"), weights.refract.expect("it refracts"));

    let text = include_str!("../FORMAT.md");
    let check = |what: &str, value: &dyn Display| {
        let row = format!("| {what} | {value} |\n");
        assert!(text.contains(&row), "FORMAT.md lacks {row}");
    };
    check("encode((1, 2, -3))", &format!("{}, {}", code.u, code.v));
    check("decode of this", &vector(code.decode()));
    check("direction of the ray", &vector(direction));
    check("t, u, v of the intersection", &words(&[hit.t, hit.u, hit.v]));
    check("reflection, origin", &vector(reflection.origin));
    check("reflection, direction", &vector(reflection.direction));
    check("refraction, origin", &vector(refraction.origin));
    check("refraction, direction", &vector(refraction.direction));
    check("weights of the dielectric", &format!("{} and {}", halves(reflect), halves(refract)));
    check("halves of 0.1, 1000000, 0.00000006", &halves(Half3::from_vec3(vec3(0.1, 1.0e6, 6.0e-8))));
}
