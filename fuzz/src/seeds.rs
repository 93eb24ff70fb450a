//! The first inputs of each target: small, sound, and made by the project's own code.

use std::sync::OnceLock;
use std::time::Duration;

use anyhow::{Result, anyhow};
use rayreel_formats::trace::Codec;
use rayreel_formats::{Limits, Trace};
use rayreel_replay::Stop;
use rayreel_study::point::segment::{Belonging, encode};
use rayreel_study::sweep::plan::{Sources, locate::Text};
use rayreel_study::sweep::run::{Settings, run};
use rayreel_study::{Folder, Plan, ReusedRows, Shard, Writer, merge, table};
use rayreel_tracer::{CaptureOutput, SampleGrid, TraceSettings, build, capture::capture};

use crate::place::Place;

/// A model with every statement that is read.
pub const OBJ: &str = "mtllib m.mtl\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
    usemtl m\nf 1/1/1 2/2/1 3/3/1 4\ng top\nusemtl n\nf 1 2 5\nf -4 -3 -1\ns 1\nf 3//1 4 5\n";

/// Its materials; one of them has a picture.
pub const MTL: &str = "newmtl m\nKd 0.5 0.4 0.3\nKs 0.2\nNs 30\nillum 3\nmap_Kd t.png\n\nnewmtl n\nKd 0.1 0.1 0.1\nTf 0.9 0.8 0.7\n\
    Ni 1.5\nd 0.5\nTr 0.5\nillum 7\nKe 0 0 0\n";

/// A scene file.
pub const SCENE: &str = "model = \"m.obj\"\n[camera]\neye = [5.0, 3.2, 7.0]\ntarget = [0.0, 0.4, 0.0]\nvfov_deg = 36.0\n[[lights]]\n\
    kind = \"point\"\nposition = [6.0, 10.0, 6.0]\n[sky]\ncolour = [0.5, 0.6, 0.75]\n[materials.m]\nreflect = 0.25\n";

/// A camera path.
pub const PATH: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,vfov_deg\n\
    0,1,2,3,0,0,0,0,1,0,40\n1,1.5,2,3,0,0,0,0,1,0,40\n";

/// A glTF model with its buffer in it: two triangles.
pub const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"translation":[0,0,-2]},
{"camera":0}],"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],"meshes":[{"primitives":[{"attributes":
{"POSITION":0},"indices":1,"material":0}]}],"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.2,1],
"metallicFactor":0.5}}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,
"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA"}],"animations":[]}"#;

/// A plan file over the trace of [`trace`].
pub const PLAN: &str = "name = \"small\"\ntraces = [\"a.rtrace\"]\nmachines = [\"sgrt-ti2\", \"none\"]\npolicies = [\"full\", \"adaptive\"]\n\
    set = [\"srp.ideal=true\"]\nexclude = ['policy == \"full\" and machine == \"none\"']\n[[axis]]\nname = \"l1\"\n\
    keys = [\"ti.trv_l1.size\", \"ti.ist_l1.size\"]\nlog = { from = \"4KiB\", to = \"16KiB\", factor = 2 }\n[[axis]]\nname = \"trv\"\n\
    key = \"ti.trv\"\nvalues = [2, 4]\n";

/// The same, of few points and no machine, to be carried out.
const FEW: &str =
    "name = \"few\"\ntraces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\", \"adaptive\"]\n";

/// The bytes of a picture of 4 x 4 pixels, by the extension of its format.
///
/// # Errors
/// Never.
pub fn picture(format: image::ImageFormat) -> Result<Vec<u8>> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_fn(4, 4, |x, y| image::Rgb([60 * x as u8, 60 * y as u8, 99]));
    pixels.write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}

/// What a sweep leaves behind.
#[derive(Debug)]
pub struct Swept {
    /// `plan.json`.
    pub plan: Vec<u8>,
    /// A segment of rows.
    pub segment: Vec<u8>,
    /// `results.parquet`.
    pub results: Vec<u8>,
}

/// A small trace: two tiles of two frames over five faces, with mirrors, glass and shadows.
///
/// # Panics
/// When it cannot be made: nothing works then.
pub fn trace(codec: Codec) -> Vec<u8> {
    let made = || -> Result<Vec<u8>> {
        let place = Place::new();
        place.put("t.png", &picture(image::ImageFormat::Png)?);
        place.put("m.mtl", MTL.as_bytes());
        place.put("m.obj", OBJ.as_bytes());
        let scene = place.put("s.toml", SCENE.as_bytes());
        let scene = rayreel_scenes::load(&scene.display().to_string())?;
        let grid = SampleGrid { width: 12, height: 6, samples: 1, tile: 8, first_frame: 0, frames: 1 };
        let meta = grid.meta(&scene, TraceSettings::default(), "fuzz");
        let output = CaptureOutput::new(place.path("a.rtrace"), codec, 3);
        capture(&scene, &build(&scene)?, &meta, &output, |_| true)?;
        Ok(std::fs::read(place.path("a.rtrace"))?)
    };
    made().expect("a small trace")
}

/// Opens [`trace`], wherever it is said to be.
///
/// # Errors
/// Never.
pub fn open(_: &str) -> Result<Trace, String> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = BYTES.get_or_init(|| trace(Codec::Context)).clone();
    Trace::from_bytes(bytes, Limits::default()).map_err(|e| e.to_string())
}

/// The plan of a text.
///
/// # Errors
/// What is wrong with it.
pub fn plan(text: &str) -> rayreel_study::Result<Plan> {
    let text = Text { name: "p.toml", text };
    Plan::new(&Sources { text, folder: "".as_ref(), traces: None, detail: None, stem: "p", open: &open })
}

/// A sweep of two points.
///
/// # Panics
/// When it cannot be carried out: nothing works then.
pub fn swept() -> &'static Swept {
    static SWEPT: OnceLock<Swept> = OnceLock::new();
    let made = || -> Result<Swept> {
        let place = Place::new();
        let (folder, _) = Folder::create(&place.path("sweep"), plan(FEW)?)?;
        let writer = Writer { attempt: "fuzz".into(), host: "here".into() };
        let (reused, flush) = (ReusedRows::default(), Duration::ZERO);
        let stop = Stop::never();
        let settings = Settings {
            shard: Shard::WHOLE,
            threads: 1,
            memory: 1 << 24,
            flush,
            writer,
            stop,
            open: &open,
            reused: &reused,
        };
        run(&folder, &settings, |_| {})?;
        let results = table::parquet::encode(&merge(&folder)?.results)?;
        let sealed = rayreel_study::sweep::segment::read(&folder, 0)?;
        let belonging = Belonging { plan: "p", bucket: 0 };
        let segment = encode(belonging, sealed.rows.values(), None)?;
        Ok(Swept { plan: folder.plan().to_json()?, segment, results })
    };
    SWEPT.get_or_init(|| made().map_err(|e| anyhow!("a small sweep: {e:#}")).expect("it works"))
}
