//! What has to be captured and replayed, each thing once however often it is asked for.

use std::path::PathBuf;
use std::sync::Arc;

use rayreel_formats::scene::Meta;
use rayreel_machine::config::NamedMachine;
use rayreel_replay::NamedPolicy;
use rayreel_scenes::Scene;

use super::cache::Cache;
use crate::common::{GridArgs, meta};

/// A scene of the experiment.
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its name as part of file names: a scene file may call it anything.
    pub name: String,
}

impl Stage {
    /// A scene with its name.
    pub fn new(scene: Scene) -> Self {
        let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let name = scene.name.chars().map(plain).collect();
        Self { scene, name }
    }
}

/// What a capture is of.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Index of the scene.
    pub scene: usize,
    /// Picture size, pixels.
    pub size: (u32, u32),
    /// Samples per pixel and axis.
    pub samples: u32,
    /// Tile edge, samples.
    pub tile: u32,
    /// First frame and number of frames.
    pub frames: (u32, u32),
}

/// Tile edge of everything but the ablation of it: the paper's tiles are not stated; 32 is what a capture takes by default.
pub const TILE: u32 = 32;

/// A trace.
pub struct Shot {
    /// Index of the scene.
    pub scene: usize,
    /// What is captured.
    pub meta: Meta,
    /// Its file; nothing if it is traced while it is replayed.
    pub path: Option<PathBuf>,
}

impl Shot {
    /// Samples of all its frames.
    pub fn samples(&self) -> u64 {
        let (columns, rows) = self.meta.grid();
        u64::from(columns) * u64::from(rows) * u64::from(self.meta.frames)
    }
}

/// A picture that a job makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Its frame.
    pub frame: u32,
    /// What it shows.
    pub kind: Kind,
    /// How many times smaller it is than the frame.
    pub shrink: u32,
    /// Its file, relative to the output folder.
    pub file: String,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The policy's picture.
    Result,
    /// That of `full`.
    Reference,
    /// Their difference.
    Error,
    /// Which samples were interpolated.
    Similarity,
    /// At what rate each tile was sampled.
    Rate,
}

/// How a picture is compared with that of `full`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// Not at all.
    Not,
    /// Value by value: PSNR and flicker.
    Valued,
    /// As a viewer sees it, too: SSIM and FLIP.
    Seen,
}

/// A replay of all frames of a shot.
#[derive(Clone)]
pub struct Job {
    /// Index of the shot.
    pub shot: usize,
    /// The policy.
    pub policy: Arc<NamedPolicy>,
    /// The machine, if there is one.
    pub machine: Option<Arc<NamedMachine>>,
    /// The frames that the machine simulates.
    pub simulated: Vec<u32>,
    /// How the picture is compared with that of `full`.
    pub compared: Compared,
    /// Whether the figures of each tile are kept.
    pub tiles: bool,
    /// The pictures that are wanted.
    pub pictures: Vec<Picture>,
}

impl Job {
    /// All that its result depends on, and the shot.
    fn inputs(&self, meta: &Meta) -> String {
        let pictures: Vec<_> = self.pictures.iter().map(|p| (p.frame, p.kind, p.shrink)).collect();
        let machine = self.machine.as_ref().map(|machine| machine.canonical()).unwrap_or_default();
        format!(
            "{meta:?}\n{:?}\n{machine}\n{:?}\n{:?} {} {pictures:?}",
            self.policy.policy, self.simulated, self.compared, self.tiles
        )
    }
}

/// Everything that is to be done.
pub struct Plan<'a> {
    /// The scenes.
    pub stages: &'a [Stage],
    /// The traces.
    pub shots: Vec<Shot>,
    /// The replays.
    pub jobs: Vec<Job>,
    /// Their names in the cache.
    pub keys: Vec<String>,
    cache: &'a Cache,
    folder: PathBuf,
}

impl<'a> Plan<'a> {
    /// Nothing yet. Traces go to `folder`.
    pub fn new(stages: &'a [Stage], cache: &'a Cache, folder: PathBuf) -> Self {
        Self { stages, shots: Vec::new(), jobs: Vec::new(), keys: Vec::new(), cache, folder }
    }

    /// The shot of a grid, in a file or `live`.
    pub fn shot(&mut self, grid: &Grid, live: bool) -> usize {
        let stage = &self.stages[grid.scene];
        let depth = rayreel_tracer::TraceSettings::default().max_depth;
        let (first, frames) = grid.frames;
        let args = GridArgs { size: grid.size, samples: grid.samples, depth };
        let meta = meta(&stage.scene, &args, grid.tile, first, frames);
        let same = |shot: &Shot| (shot.scene, shot.path.is_none()) == (grid.scene, live) && shot.meta == meta;
        if let Some(known) = self.shots.iter().position(same) {
            return known;
        }
        let ((w, h), n) = (grid.size, grid.samples);
        let mut name = format!("{}-{w}x{h}-{n}x{n}", stage.name);
        if grid.tile != TILE {
            name += &format!("-tile{}", grid.tile);
        }
        if grid.frames != (0, 1) {
            name += &format!("-frames{first}-{}", first + frames - 1);
        }
        let path = (!live).then(|| self.folder.join(name + ".rtrace"));
        self.shots.push(Shot { scene: grid.scene, meta, path });
        self.shots.len() - 1
    }

    /// The job, new or known.
    pub fn job(&mut self, job: Job) -> usize {
        let key = self.cache.key(&job.inputs(&self.shots[job.shot].meta));
        if let Some(known) = self.keys.iter().position(|k| *k == key) {
            return known;
        }
        self.keys.push(key);
        self.jobs.push(job);
        self.jobs.len() - 1
    }

    /// The name of a shot's scene.
    pub fn scene_of(&self, shot: &Shot) -> &str {
        &self.stages[shot.scene].name
    }
}
