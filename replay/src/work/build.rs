//! A decided tile as work for the machine: the rays of its traced samples, round by round.
//!
//! A tile's last columns and rows are work of the tiles that close them (see [`Closer`]).
//!
//! Every path is known to lead through the tree, or checked while it is turned into operations. What a tile traces of its neighbours
//! (`Apron::Retrace`) stands behind its own rays.

use rayreel_formats::tile::{RayKind, RayNode, Tile};

use super::part::{Part, Parts, bad};
use super::recorded::PathsOf;
use crate::error::{RayStep, ReplayError, Result};
use crate::policy::view::{CLOSERS, Closer, SampleState, TileView, Traced};
use crate::source::PathSource;
use rayreel_machine::work::check::{Fault, walk};
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{NO_RAY, NO_TRIANGLE, RayWork};

/// Turns samples into rays.
pub(crate) struct Builder<'a, S: ?Sized> {
    pub source: &'a S,
    pub tree: &'a Topology,
    /// Samples of a pixel.
    pub samples_a_pixel: u32,
}

/// The last node of each depth on the way down a ray tree.
const DEPTHS: usize = 16;

impl<S: PathSource + ?Sized> Builder<'_, S> {
    /// All that is traced, tested and interpolated of a tile, by who does it.
    pub fn tile(&self, view: &TileView, tile: &Tile, paths: PathsOf<'_>) -> Result<Parts> {
        let mut recorded = Recorded::new(tile, paths)?;
        let mut parts = Parts::default();
        for closer in CLOSERS {
            let part = &mut parts.0[closer as usize];
            recorded.begin_part();
            let samples = view.samples().filter(|&(x, y)| view.closer(x, y) == closer);
            self.samples(part, view, &mut recorded, samples)?;
            part.count(view.rounds(closer));
            part.looked_up.extend_from_slice(view.looked_up(closer));
        }
        let part = &mut parts.0[Closer::Itself as usize];
        part.secondary_hits = view.secondary_hits();
        // Three channels of a pixel, each of its samples compared.
        part.audited_samples = (view.audits().values / 3) as u32 * self.samples_a_pixel;
        Ok(parts)
    }

    /// Those of `samples` that were traced.
    pub fn apron(
        &self,
        part: &mut Part,
        view: &TileView,
        tile: &Tile,
        paths: PathsOf<'_>,
        samples: &[(u32, u32)],
    ) -> Result<()> {
        self.samples(part, view, &mut Recorded::new(tile, paths)?, samples.iter().copied())
    }

    /// Appends the rays of those of `samples` that were traced.
    fn samples(
        &self,
        part: &mut Part,
        view: &TileView,
        recorded: &mut Recorded<'_>,
        samples: impl Iterator<Item = (u32, u32)>,
    ) -> Result<()> {
        let rect = view.rect();
        for (x, y) in samples {
            let Some((state, round)) = view.state(x, y) else { continue };
            if state == SampleState::Interpolated {
                continue;
            }
            let sample = (y - rect.y) as usize * rect.width as usize + (x - rect.x) as usize;
            part.samples += 1;
            let traces = |node| view.traces_hit(sample, node);
            self.sample(part, recorded, (sample, round, traces), (x, y))?;
        }
        Ok(())
    }

    /// Appends those rays of a sample's tree that `traces` tells of, by hit. A ray whose parent was not traced (a primary ray,
    /// or the child of an interpolated hit) is one that the SRP starts.
    fn sample(
        &self,
        part: &mut Part,
        recorded: &mut Recorded<'_>,
        (sample, round, traces): (usize, u8, impl Fn(usize) -> Traced),
        at: (u32, u32),
    ) -> Result<()> {
        // Per depth the last hit: its ray if it was traced, what it is, and whether its children were announced.
        let (mut ancestors, tile) = (Ancestors { above: [None; DEPTHS] }, recorded.tile);
        let nodes = tile.tree.sample(sample);
        for (i, node) in nodes.clone().enumerate() {
            let hit = &tile.tree.nodes[node];
            let parent = ancestors.parent(hit, i == 0).map_err(|detail| bad(tile, detail))?;
            let traced = traces(i);
            let ray = (traced != Traced::No).then_some(part.rays.len() as u32);
            if let Some(ray) = ray {
                match parent.map(|up| &mut part.rays[up as usize]) {
                    Some(up) if hit.class.kind() == RayKind::Reflection => up.reflect = ray,
                    Some(up) => up.refract = ray,
                    None => part.round(round.into()).starts.push(ray),
                }
                self.rays(part, recorded, node, traced, at)?;
            }
            ancestors.note(hit, ray).map_err(|()| lacking(tile, at))?;
        }
        ancestors.finish().map_err(|()| lacking(tile, at))
    }

    /// Appends the ray of a node and the shadow rays of its hit.
    fn rays(
        &self,
        part: &mut Part,
        recorded: &mut Recorded<'_>,
        node: usize,
        traced: Traced,
        (x, y): (u32, u32),
    ) -> Result<()> {
        let (tile, number) = (recorded.tile, recorded.index[node]);
        let hit = &tile.tree.nodes[node];
        let triangle = tile.hits[node].triangle;
        let known = if let Traced::But(known) = traced { known } else { 0 };
        let shadows = hit.shadows.count();
        if hit.hit != (triangle < self.tree.triangles) || !hit.hit && (shadows > 0 || hit.reflect || hit.refract) {
            return Err(bad(tile, format!("ray {number} of sample ({x}, {y}) and its hit disagree")));
        }
        let mut ray = RayWork {
            ops_start: 0,
            ops_len: 0,
            kind: hit.class.kind(),
            shadows: (shadows - known.count_ones()) as u8,
            triangle: if hit.hit { triangle } else { NO_TRIANGLE },
            material: if hit.hit { self.source.material_of(triangle) } else { 0 },
            reflect: NO_RAY,
            refract: NO_RAY,
            x,
            y,
            depth: hit.class.depth() as u8,
            known_lights: known.count_ones() as u8,
        };
        self.ray(part, recorded, number, ray)?;
        // Shadow rays have the place of the ray they hang on, and no surface of their own.
        (ray.kind, ray.shadows, ray.triangle, ray.material) = (RayKind::Shadow, 0, NO_TRIANGLE, 0);
        ray.known_lights = 0;
        let cast = (1..).zip(hit.shadows.cast()).filter(|(_, light)| known >> (2 * light) & 1 == 0);
        cast.into_iter().try_for_each(|(shadow, _)| self.ray(part, recorded, number + shadow, ray))
    }

    /// Appends a ray with its path.
    fn ray(&self, part: &mut Part, recorded: &mut Recorded<'_>, number: u32, ray: RayWork) -> Result<()> {
        let tile = recorded.tile;
        let broken = |step, detail: &str| ReplayError::Corrupt {
            frame: tile.frame,
            tile: tile.index,
            ray: Some(RayStep { x: ray.x, y: ray.y, ray: number, step }),
            detail: detail.into(),
        };
        let shadow = ray.kind == RayKind::Shadow;
        let added = recorded.add(self.tree, part, number, shadow).map_err(|f| broken(f.step, f.detail))?;
        if u32::try_from(part.ops.len()).is_err() {
            return Err(bad(tile, format!("{} operations are more than a tile can have", part.ops.len())));
        }
        if !shadow && added.hit != ray.triangle {
            return Err(broken(added.steps, "the path ends at another triangle than the recorded hit"));
        }
        part.rays.push(RayWork { ops_start: added.ops_start, ops_len: added.ops_len, ..ray });
        Ok(())
    }
}

/// A tile whose rays are appended to a part.
struct Recorded<'a> {
    tile: &'a Tile,
    paths: PathsOf<'a>,
    /// Per node its first ray.
    index: Vec<u32>,
    /// Per path where its operations begin in the part; rays of one path share them.
    copied: Vec<u32>,
}

/// Not in the part yet.
const NOT_COPIED: u32 = u32::MAX;

/// A path that is in the part.
struct Added {
    ops_start: u32,
    ops_len: u32,
    steps: u32,
    hit: u32,
}

impl<'a> Recorded<'a> {
    fn new(tile: &'a Tile, paths: PathsOf<'a>) -> Result<Self> {
        let index = tile.tree.ray_index();
        let found = paths.rays();
        if index.last().is_none_or(|&rays| rays as usize != found) {
            return Err(bad(tile, format!("{found} paths where {} rays belong", tile.tree.ray_count())));
        }
        let copied = match paths {
            PathsOf::Known(paths) => vec![NOT_COPIED; paths.paths()],
            PathsOf::Steps(_) => Vec::new(),
        };
        Ok(Self { tile, paths, index, copied })
    }

    /// What is added from now on belongs to another part.
    fn begin_part(&mut self) {
        self.copied.fill(NOT_COPIED);
    }

    /// Adds the path of a ray to `part`.
    ///
    /// # Errors
    /// What is wrong with it.
    #[inline]
    fn add(&mut self, tree: &Topology, part: &mut Part, ray: u32, shadow: bool) -> Result<Added, Fault> {
        const NOT_THERE: Fault = Fault { step: 0, detail: "its steps are not in the tile" };
        match self.paths {
            PathsOf::Known(paths) => {
                let path = paths.of_ray(ray).ok_or(NOT_THERE)?;
                let (known, ops) = paths.path(path);
                let copied = &mut self.copied[path as usize];
                if *copied == NOT_COPIED {
                    *copied = part.ops.len() as u32;
                    part.ops.extend_from_slice(ops);
                }
                part.paths += known.counts;
                Ok(Added { ops_start: *copied, ops_len: ops.len() as u32, steps: known.steps, hit: known.hit })
            }
            PathsOf::Steps(paths) => {
                let (start, steps) = paths.spans[ray as usize];
                let found = paths.steps.get(start as usize..).and_then(|rest| rest.get(..steps as usize));
                let ops_start = part.ops.len() as u32;
                let hit = walk(tree, found.ok_or(NOT_THERE)?, shadow, &mut part.ops, &mut part.paths)?.hit;
                Ok(Added { ops_start, ops_len: part.ops.len() as u32 - ops_start, steps, hit })
            }
        }
    }
}

/// The way down to a hit of a ray tree: the last hit of each depth.
struct Ancestors {
    above: [Option<Ancestor>; DEPTHS],
}

/// A hit whose children may be still to come.
#[derive(Clone, Copy)]
struct Ancestor {
    class: u16,
    /// Its ray in the work, if that is traced.
    ray: Option<u32>,
    reflect: bool,
    refract: bool,
}

impl Ancestors {
    /// The ray that spawned `node`, if it is traced. The hit above must be there and have announced the child.
    fn parent(&mut self, node: &RayNode, primary: bool) -> Result<Option<u32>, String> {
        let class = node.class;
        if (class.0 == 1) != primary || class.0 == 0 {
            let wanted = if primary { "primary" } else { "secondary" };
            return Err(format!("ray class {} where a {wanted} ray belongs", class.0));
        }
        let Some(parent) = class.parent() else { return Ok(None) };
        let slot = self.above[parent.depth() as usize].as_mut().filter(|above| above.class == parent.0);
        let reflects = class.kind() == RayKind::Reflection;
        let open = slot.map(|above| (above.ray, if reflects { &mut above.reflect } else { &mut above.refract }));
        match open {
            Some((ray, awaited)) if *awaited => {
                *awaited = false;
                Ok(ray)
            }
            _ => Err(format!("ray class {} has no parent", class.0)),
        }
    }

    /// Takes note of `node`; an error if a child of the hit that was last at its depth did not come.
    fn note(&mut self, node: &RayNode, ray: Option<u32>) -> Result<(), ()> {
        let above = Ancestor { class: node.class.0, ray, reflect: node.reflect, refract: node.refract };
        match self.above[node.class.depth() as usize].replace(above) {
            Some(old) if old.reflect || old.refract => Err(()),
            _ => Ok(()),
        }
    }

    /// An error if a child that was announced did not come.
    fn finish(&self) -> Result<(), ()> {
        let awaited = self.above.iter().flatten().any(|above| above.reflect || above.refract);
        if awaited { Err(()) } else { Ok(()) }
    }
}

fn lacking(tile: &Tile, at: (u32, u32)) -> ReplayError {
    bad(tile, format!("sample {at:?} lacks a ray that was spawned"))
}
