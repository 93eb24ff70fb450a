//! A decided tile as work for the machine: the rays of its traced samples, wave by wave.
//!
//! Every path is checked against the tree while it is turned into operations. What a tile traces of its neighbours
//! (`Apron::Retrace`) stands behind its own rays.

use rayreel_formats::tile::{RayKind, RayNode, Tile};

use super::check::{PathCounts, walk};
use super::ops::Op;
use super::topology::Topology;
use super::{NO_RAY, NO_TRIANGLE, RayWork, TileWork, Wave};
use crate::error::{ReplayError, Result};
use crate::policy::view::{SampleState, TileView, WaveCounts};
use crate::source::PathSource;

/// A tile as work, and what its paths ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// The work.
    pub work: TileWork,
    /// Sums over all its rays, apron included.
    pub paths: PathCounts,
}

/// Rays of some samples of one recorded tile, numbered from 0.
#[derive(Debug, Default)]
pub(crate) struct Part {
    rays: Vec<RayWork>,
    waves: Vec<Wave>,
    paths: PathCounts,
    samples: u32,
    ops: Vec<Op>,
}

/// Turns samples into rays.
pub(crate) struct Builder<'a, S: ?Sized> {
    pub source: &'a S,
    pub tree: &'a Topology,
}

/// The last node of each depth on the way down a ray tree.
const DEPTHS: usize = 16;

impl<S: PathSource + ?Sized> Builder<'_, S> {
    /// All that a tile traces, tests and interpolates itself.
    pub fn own(&self, view: &TileView, tile: &Tile) -> Result<Part> {
        let rect = view.rect();
        let mut part = Part::default();
        let samples = (rect.y..rect.y + rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)));
        self.samples(&mut part, view, tile, samples)?;
        part.count(view.waves());
        Ok(part)
    }

    /// Those of `samples` that were traced.
    pub fn apron(&self, part: &mut Part, view: &TileView, tile: &Tile, samples: &[(u32, u32)]) -> Result<()> {
        self.samples(part, view, tile, samples.iter().copied())
    }

    /// Appends the rays of those of `samples` that were traced.
    fn samples(
        &self,
        part: &mut Part,
        view: &TileView,
        tile: &Tile,
        samples: impl Iterator<Item = (u32, u32)>,
    ) -> Result<()> {
        let rect = view.rect();
        let index = tile.tree.ray_index();
        if index.last().is_none_or(|&rays| rays as usize != tile.paths.spans.len()) {
            let detail = format!("{} paths where {} rays belong", tile.paths.spans.len(), tile.tree.ray_count());
            return Err(bad(tile, detail));
        }
        for (x, y) in samples {
            let Some((SampleState::Reference | SampleState::Traced, wave)) = view.state(x, y) else { continue };
            let sample = (y - rect.y) as usize * rect.width as usize + (x - rect.x) as usize;
            let primary = part.rays.len() as u32;
            part.wave(wave).primaries.push(primary);
            part.samples += 1;
            self.sample(part, tile, &index, sample, (x, y))?;
        }
        Ok(())
    }

    /// Appends the ray tree of a sample.
    fn sample(&self, part: &mut Part, tile: &Tile, index: &[u32], sample: usize, at: (u32, u32)) -> Result<()> {
        let mut parents = [NO_RAY; DEPTHS];
        let nodes = tile.tree.sample(sample);
        let first = part.rays.len();
        for node in nodes.clone() {
            let own = &tile.tree.nodes[node];
            let ray = part.rays.len() as u32;
            link(&mut part.rays, &mut parents, own, ray, node == nodes.start).map_err(|detail| bad(tile, detail))?;
            self.rays(part, tile, node, index[node], at)?;
        }
        let children = tile.tree.nodes[nodes].iter().map(|n| usize::from(n.reflect) + usize::from(n.refract));
        let linked = |ray: &RayWork| usize::from(ray.reflect != NO_RAY) + usize::from(ray.refract != NO_RAY);
        if children.sum::<usize>() != part.rays[first..].iter().map(linked).sum::<usize>() {
            return Err(bad(tile, format!("sample {at:?} lacks a ray that was spawned")));
        }
        Ok(())
    }

    /// Appends the ray of a node and the shadow rays of its hit.
    fn rays(&self, part: &mut Part, tile: &Tile, node: usize, number: u32, (x, y): (u32, u32)) -> Result<()> {
        let own = &tile.tree.nodes[node];
        let triangle = tile.hits[node].triangle;
        let shadows = own.shadows.count();
        if own.hit != (triangle < self.tree.triangles) || !own.hit && (shadows > 0 || own.reflect || own.refract) {
            return Err(bad(tile, format!("ray {number} of sample ({x}, {y}) and its hit disagree")));
        }
        let mut ray = RayWork {
            ops_start: 0,
            ops_len: 0,
            kind: own.class.kind(),
            shadows: shadows as u8,
            triangle: if own.hit { triangle } else { NO_TRIANGLE },
            material: if own.hit { self.source.material_of(triangle) } else { 0 },
            reflect: NO_RAY,
            refract: NO_RAY,
            x,
            y,
            depth: own.class.depth() as u8,
        };
        self.ray(part, tile, number, ray)?;
        // Shadow rays have the place of the ray they hang on, and no surface of their own.
        (ray.kind, ray.shadows, ray.triangle, ray.material) = (RayKind::Shadow, 0, NO_TRIANGLE, 0);
        (1..=shadows).try_for_each(|shadow| self.ray(part, tile, number + shadow, ray))
    }

    /// Checks the path of a ray and appends it.
    fn ray(&self, part: &mut Part, tile: &Tile, number: u32, ray: RayWork) -> Result<()> {
        let (start, len) = tile.paths.spans[number as usize];
        let ops_start = part.ops.len() as u32;
        let shadow = ray.kind == RayKind::Shadow;
        let broken = |step, detail| ReplayError::BadPath {
            frame: tile.frame,
            tile: tile.index,
            x: ray.x,
            y: ray.y,
            ray: number,
            step,
            detail,
        };
        let steps = tile.paths.steps.get(start as usize..).and_then(|rest| rest.get(..len as usize));
        let steps = steps.ok_or_else(|| broken(0, "its steps are not in the tile"))?;
        let walked =
            walk(self.tree, steps, shadow, &mut part.ops, &mut part.paths).map_err(|f| broken(f.step, f.detail))?;
        if u32::try_from(part.ops.len()).is_err() {
            return Err(bad(tile, format!("{} operations are more than a tile can have", part.ops.len())));
        }
        if !shadow && walked.hit != ray.triangle {
            return Err(broken(len, "the path ends at another triangle than the recorded hit"));
        }
        part.rays.push(RayWork { ops_start, ops_len: part.ops.len() as u32 - ops_start, ..ray });
        Ok(())
    }
}

/// Notes ray `ray` as child of its parent.
fn link(
    rays: &mut [RayWork],
    parents: &mut [u32; DEPTHS],
    node: &RayNode,
    ray: u32,
    primary: bool,
) -> Result<(), String> {
    let class = node.class;
    if (class.0 == 1) != primary || class.0 == 0 {
        return Err(format!(
            "ray class {} where a {} ray belongs",
            class.0,
            if primary { "primary" } else { "secondary" }
        ));
    }
    let depth = class.depth() as usize;
    if let Some(parent) = class.parent() {
        let slot = rays.get_mut(parents[parent.depth() as usize] as usize);
        let slot = slot.map(|up| if class.0.is_multiple_of(2) { &mut up.reflect } else { &mut up.refract });
        match slot {
            Some(child) if *child == NO_RAY => *child = ray,
            _ => return Err(format!("ray class {} has no parent", class.0)),
        }
    }
    parents[depth] = ray;
    // What is deeper belongs to another subtree from here on.
    parents[depth + 1..].fill(NO_RAY);
    Ok(())
}

impl Part {
    fn wave(&mut self, wave: u8) -> &mut Wave {
        let wave = usize::from(wave);
        if self.waves.len() <= wave {
            self.waves.resize(wave + 1, Wave::default());
        }
        &mut self.waves[wave]
    }

    /// Adds tests and interpolated samples.
    pub fn count(&mut self, waves: &[WaveCounts]) {
        for (wave, counts) in (0..).zip(waves) {
            let own = self.wave(wave);
            own.tests += counts.tests;
            own.interpolated += counts.interpolated;
        }
    }

    /// Joins what a tile does itself with what it does for its apron.
    ///
    /// # Errors
    /// When the operations cannot be numbered.
    pub fn join(mut self, apron: Self, tile: &Tile, border_samples: u32) -> Result<Built> {
        let (op_base, ray_base) = (self.ops.len() as u32, self.rays.len() as u32);
        if u32::try_from(self.ops.len() + apron.ops.len()).is_err() {
            return Err(bad(tile, "its operations are more than a tile can have".into()));
        }
        self.ops.extend(apron.ops);
        let moved = |ray: u32| if ray == NO_RAY { NO_RAY } else { ray + ray_base };
        self.rays.extend(apron.rays.iter().map(|ray| RayWork {
            ops_start: ray.ops_start + op_base,
            reflect: moved(ray.reflect),
            refract: moved(ray.refract),
            ..*ray
        }));
        for (number, wave) in (0..).zip(apron.waves) {
            let own = self.wave(number);
            own.tests += wave.tests;
            own.interpolated += wave.interpolated;
            own.primaries.extend(wave.primaries.into_iter().map(moved));
        }
        while self.waves.last().is_some_and(|wave| *wave == Wave::default()) {
            self.waves.pop();
        }
        let mut paths = self.paths;
        paths += apron.paths;
        let work = TileWork {
            frame: tile.frame,
            tile: tile.index,
            rect: tile.rect,
            apron_samples: apron.samples,
            border_samples,
            rays: self.rays,
            ops: self.ops,
            waves: self.waves,
        };
        Ok(Built { work, paths })
    }
}

fn bad(tile: &Tile, detail: String) -> ReplayError {
    ReplayError::BadTile { frame: tile.frame, tile: tile.index, detail }
}
