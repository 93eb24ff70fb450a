//! What has to be captured and replayed, each thing once however often it is asked for.

use std::path::PathBuf;

use rayreel_formats::scene::Meta;
use rayreel_study::point::key::Point;
use rayreel_study::point::wanted::Views;
use rayreel_tracer::{SampleGrid, TraceSettings};

use crate::identity::identity;
use crate::setup::{Setup, Stage};

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

/// Some frames of a scene that are traced.
pub struct Capture {
    /// Index of the scene.
    pub scene: usize,
    /// What is captured.
    pub meta: Meta,
    /// Which capture it is, before there is a trace of it.
    pub identity: String,
    /// The file of its trace; nothing if it is traced while it is replayed.
    pub path: Option<PathBuf>,
}

impl Capture {
    /// Samples of all its frames.
    pub fn samples(&self) -> u64 {
        let (columns, rows) = self.meta.grid();
        u64::from(columns) * u64::from(rows) * u64::from(self.meta.frames)
    }

    /// Whether it is traced while it is replayed.
    pub fn is_live(&self) -> bool {
        self.path.is_none()
    }
}

/// A point on a capture.
#[derive(Clone)]
pub struct PlannedPoint {
    /// Index of the capture.
    pub capture: usize,
    /// The point. As long as its capture is not made, its source is the capture's identity.
    pub point: Point,
    /// Files of its pictures, relative to the output folder.
    pub files: Vec<String>,
}

/// Everything that is to be done.
pub struct Plan<'a> {
    /// The scenes.
    pub stages: &'a [Stage],
    /// What is traced.
    pub captures: Vec<Capture>,
    /// The points.
    pub points: Vec<PlannedPoint>,
    tool: &'a str,
    folder: PathBuf,
}

impl<'a> Plan<'a> {
    /// Nothing yet. Traces go to `folder`.
    pub fn new(setup: &'a Setup, folder: PathBuf) -> Self {
        Self { stages: &setup.stages, captures: Vec::new(), points: Vec::new(), tool: &setup.tool, folder }
    }

    /// The capture of a grid, in a file or `live`.
    pub fn capture(&mut self, grid: &Grid, live: bool) -> usize {
        let stage = &self.stages[grid.scene];
        let ((width, height), (first_frame, frames)) = (grid.size, grid.frames);
        let of = SampleGrid { width, height, samples: grid.samples, tile: grid.tile, first_frame, frames };
        let meta = of.meta_of((&stage.scene, stage.content), TraceSettings::default(), self.tool);
        let same = |known: &Capture| (known.scene, known.is_live()) == (grid.scene, live) && known.meta == meta;
        if let Some(known) = self.captures.iter().position(same) {
            return known;
        }
        let path = (!live).then(|| self.folder.join(format!("{}.rtrace", file_stem(stage, grid))));
        self.captures.push(Capture { scene: grid.scene, identity: identity(&meta), meta, path });
        self.captures.len() - 1
    }

    /// The point on capture `capture`, new or known: one that wants the same figures is the same if only one of the two has
    /// views, or both the same. `files` are those of its pictures.
    pub fn point(&mut self, capture: usize, point: Point, files: Vec<String>) -> usize {
        let point = Point { source: self.captures[capture].identity.clone(), ..point };
        let figures = |point: &Point| Point { wanted: without_views(point), ..point.clone() };
        let (row, details) = (figures(&point).row_key(), figures(&point).details_key());
        let views = &point.wanted.views;
        let same = |known: &PlannedPoint| {
            let known_views = &known.point.wanted.views;
            let plain = figures(&known.point);
            (plain.row_key(), plain.details_key()) == (row.clone(), details.clone())
                && known.capture == capture
                && (row.is_some() && (known_views.is_empty() || views.is_empty()) || known_views == views)
        };
        let Some(known) = self.points.iter().position(same) else {
            self.points.push(PlannedPoint { capture, point, files });
            return self.points.len() - 1;
        };
        if self.points[known].point.wanted.views.is_empty() {
            self.points[known] = PlannedPoint { capture, point, files };
        }
        known
    }

    /// The name of a capture's scene.
    pub fn scene_of(&self, capture: &Capture) -> &str {
        &self.stages[capture.scene].name
    }
}

fn without_views(point: &Point) -> rayreel_study::point::wanted::Wanted {
    let mut wanted = point.wanted.clone();
    wanted.views = Views::default();
    wanted
}

fn file_stem(stage: &Stage, grid: &Grid) -> String {
    let ((width, height), n, (first, frames)) = (grid.size, grid.samples, grid.frames);
    let mut name = format!("{}-{width}x{height}-{n}x{n}", stage.name);
    if grid.tile != TILE {
        name += &format!("-tile{}", grid.tile);
    }
    if grid.frames != (0, 1) {
        name += &format!("-frames{first}-{}", first + frames - 1);
    }
    name
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rayreel_replay::NamedPolicy;
    use rayreel_study::point::wanted::{Kind, PictureWanted, Wanted};

    use super::*;

    #[test]
    fn a_point_is_planned_once_with_all_that_is_wanted_of_it() {
        let setup = Setup::new([rayreel_scenes::load("cornell").unwrap()], None).unwrap();
        let mut plan = Plan::new(&setup, PathBuf::new());
        let grid = Grid { scene: 0, size: (32, 16), samples: 1, tile: TILE, frames: (0, 1) };
        let capture = plan.capture(&grid, false);
        assert_eq!(plan.capture(&grid, false), capture);
        assert_ne!(plan.capture(&grid, true), capture);
        let policy = Arc::new(NamedPolicy::load("adaptive", &[]).unwrap());
        let point = |pictures: &[PictureWanted]| Point {
            source: String::new(),
            frames: (0, 1),
            machine: None,
            policy: Arc::clone(&policy),
            detail: setup.detail,
            wanted: Wanted { views: Views { tiles: false, pictures: pictures.to_vec() }, ..Wanted::default() },
        };
        let picture = PictureWanted { frame: 0, kind: Kind::Result, shrink: 1 };
        let plain = plan.point(capture, point(&[]), Vec::new());
        assert_eq!(plan.point(capture, point(&[picture]), vec!["a.png".into()]), plain, "the same row");
        assert_eq!(plan.point(capture, point(&[]), Vec::new()), plain);
        assert_eq!(plan.points[plain].files, ["a.png"], "the picture is not forgotten");
        let smaller = PictureWanted { shrink: 2, ..picture };
        assert_ne!(plan.point(capture, point(&[smaller]), vec!["b.png".into()]), plain, "another picture");
    }
}
