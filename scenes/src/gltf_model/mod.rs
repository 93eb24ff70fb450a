//! glTF 2.0 models, as `.gltf` and `.glb`.
//!
//! The `gltf` crate reads the JSON; everything that an index, a length or a URI can break is checked here. What the scene
//! cannot say is counted in warnings. The geometry of a scene is one: animated meshes stand as at one frame, while an
//! animated camera gives a camera for each frame.

mod accessor;
mod animation;
mod cameras;
mod document;
mod lights;
mod materials;
mod nodes;
mod primitive;
mod skin;
mod textures;
mod uri;

use std::path::{Path, PathBuf};

use glam::{DAffine3, Vec3};

use self::{
    animation::Animations,
    document::Source,
    materials::Surface,
    nodes::{Tree, label},
    primitive::{Budget, Target},
    skin::Binding,
    textures::Pictures,
};
use crate::{
    camera::MAX_FRAMES,
    defaults::main_bounds,
    error::{Location, SceneError},
    options::LoadOptions,
    scene::{Camera, Light, Material, Mesh, Texture},
    warnings::{Warning, Warnings},
};

/// What a glTF file holds.
pub(crate) struct GltfModel {
    pub mesh: Mesh,
    /// What default camera and lights are made for, where meshes move: so they stand still.
    pub film: Option<Film>,
    /// One name per node with a mesh.
    pub objects: Vec<String>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    /// The file's lights; none where it has none that shines.
    pub lights: Vec<Light>,
    /// The file's camera for each frame; none where it has no camera.
    pub cameras: Vec<Camera>,
    /// Frames of its animation, at least one.
    pub frames: u64,
    pub warnings: Vec<Warning>,
    /// The model's own, and those that it names.
    pub files: Vec<PathBuf>,
}

/// Meshes that move, as they are seen on the whole.
pub(crate) struct Film {
    /// The mesh at the first of these moments at which there is one.
    pub first: Mesh,
    /// The box of what is seen at some moments of the animation.
    pub bounds: (Vec3, Vec3),
}

/// Moments of an animation whose meshes a default view has to hold, evenly spread from the first to the last.
const MOMENTS: u32 = 5;

/// Loads a `.gltf` or `.glb` file.
pub(crate) fn load_gltf(path: &Path, options: &LoadOptions) -> Result<GltfModel, SceneError> {
    if path.is_dir() {
        return Err(SceneError::folder(path, "glTF file"));
    }
    let mut warnings = Warnings::default();
    let source = Source::open(path)?;
    tell_ignored(&source, &mut warnings);
    let animations = Animations::read(&source, options.fps(), &mut warnings)?;
    let tree = Tree::new(&source, &animations, &mut warnings)?;
    let lens = cameras::first(&source, &tree, &mut warnings);
    let solid = |node: usize| source.root().nodes[node].mesh.is_some();
    let shines = |node: usize| lights::named(&source, node).is_some();
    // A mesh with a skin moves with its joints.
    let moves = |place: usize, node: usize| match source.root().nodes[node].skin {
        Some(skin) => {
            let mut joints = source.root().skins[skin.value()].joints.iter();
            joints.any(|joint| tree.place(joint.value()).is_some_and(|place| tree.moves(place, &animations)))
        }
        None => tree.moves(place, &animations),
    };
    let moving =
        |is: &dyn Fn(usize) -> bool| tree.nodes().filter(|(place, node)| is(*node) && moves(*place, *node)).count();
    let (moving_meshes, moving) = (moving(&solid), moving(&|node| solid(node) || shines(node)));
    let flies = lens.as_ref().is_some_and(|lens| tree.moves(lens.place, &animations));
    let frames = if moving > 0 || flies { frames(path, &animations, options)? } else { 1 };
    tell_moving(path, moving, options, &mut warnings);
    let world = tree.world(&animations, f64::from(options.frame) / options.fps());
    let mut model = Builder { source: &source, pictures: Pictures::default(), surfaces: Vec::new() };
    let (mesh, objects) = model.meshes(&tree, &world, &mut warnings)?;
    if mesh.triangles.is_empty() {
        return Err(model.empty(moving_meshes > 0, options));
    }
    let film = if moving_meshes > 0 { model.film(&tree, &animations)? } else { None };
    let materials = model.materials();
    let (low, high) = main_bounds(&film.as_ref().map_or(&mesh, |film| &film.first).positions);
    let middle = (low + high) / 2.0;
    let stands = tree.nodes().map(|(place, node)| (node, world[place]));
    let lights = lights::lights(&source, stands, (middle, (high - low).length() / 2.0), &mut warnings)?;
    let camera = |lens: &cameras::Lens| -> Result<Vec<Camera>, SceneError> {
        let at = |frame: u64| tree.world_of(lens.place, &animations, frame as f64 / options.fps());
        (0..frames).map(|frame| cameras::camera(&source, lens, &at(frame), middle)).collect()
    };
    let cameras = lens.as_ref().map(camera).transpose()?.unwrap_or_default();
    let textures = model.pictures.into_list();
    let (warnings, files) = (warnings.into_list(), source.files());
    Ok(GltfModel { mesh, film, objects, materials, textures, lights, cameras, frames, warnings, files })
}

/// Frames of the animation: one at its start, and each whole one until its end.
fn frames(path: &Path, animations: &Animations, options: &LoadOptions) -> Result<u64, SceneError> {
    // An end that is a frame up to the rounding of its seconds is that frame.
    let last = animation::rounded_up(animations.end() * options.fps()).floor();
    if last < MAX_FRAMES as f64 {
        return Ok(last as u64 + 1);
    }
    Err(SceneError::Limit {
        at: Location::File(path.to_owned()),
        what: format!("its animation has {} frames at {} frames a second", last + 1.0, options.fps()),
        fix: "at most a million are possible: take fewer frames a second".into(),
    })
}

/// A trace has one geometry and one set of lights: tells that they stand still where several frames are asked for.
fn tell_moving(path: &Path, moving: usize, options: &LoadOptions, warnings: &mut Warnings) {
    if options.frames < 2 {
        return;
    }
    for _ in 0..moving {
        warnings.add("moving", || {
            format!(
                "{}: a trace has one geometry: moving meshes and lights stand as at frame {}; take frames one by one to have each",
                path.display(),
                options.frame
            )
        });
    }
}

/// Copies of a mesh at other places.
const INSTANCES: &str = "EXT_mesh_gpu_instancing";

/// Counts what no part of the loader reads.
fn tell_ignored(source: &Source, warnings: &mut Warnings) {
    // The file names it at its head too, where nothing says what becomes of it.
    let has = |name: &str| source.root().nodes.iter().any(|n| n.extensions.iter().any(|e| e.others.contains_key(name)));
    let file = source.path.display();
    let told = source.told();
    for name in source
        .root()
        .extensions_used
        .iter()
        .filter(|name| !document::is_read(name) && !told.contains(*name) && !has(name))
    {
        warnings.add(&format!("extension {name}"), || format!("{file}: the extension {name} is not read"));
    }
    for (index, node) in source.root().nodes.iter().enumerate() {
        for name in node.extensions.iter().flat_map(|extensions| extensions.others.keys()) {
            warnings.add(&format!("extension {name}"), || {
                let drawn = if name == INSTANCES { ": one copy is drawn, where the node stands" } else { "" };
                format!("{file}: {}: the extension {name} is not read{drawn}", label(source, index))
            });
        }
    }
}

struct Builder<'a> {
    source: &'a Source,
    pictures: Pictures,
    /// Per material used the file's index (none: the default material) and what it became.
    surfaces: Vec<(Option<usize>, Surface)>,
}

impl Builder<'_> {
    /// The meshes of an animation on the whole; none if none has an area at the moments that are looked at.
    fn film(&mut self, tree: &Tree, animations: &Animations) -> Result<Option<Film>, SceneError> {
        let mut film: Option<Film> = None;
        for moment in 0..MOMENTS {
            let time = animations.end() * f64::from(moment) / f64::from(MOMENTS - 1);
            // What is odd is told of the frame that is asked for, which has the same meshes.
            let (mesh, _) = self.meshes(tree, &tree.world(animations, time), &mut Warnings::default())?;
            // Things that appear later, or go, are scaled to nothing before or after.
            if mesh.triangles.is_empty() {
                continue;
            }
            let (low, high) = main_bounds(&mesh.positions);
            match &mut film {
                Some(film) => film.bounds = (film.bounds.0.min(low), film.bounds.1.max(high)),
                None => film = Some(Film { first: mesh, bounds: (low, high) }),
            }
        }
        Ok(film)
    }

    /// All meshes of the scene where their nodes stand, one object per node, and the names of the objects.
    fn meshes(
        &mut self,
        tree: &Tree,
        world: &[DAffine3],
        warnings: &mut Warnings,
    ) -> Result<(Mesh, Vec<String>), SceneError> {
        let root = self.source.root();
        let (mut mesh, mut objects, mut budget) = (Mesh::default(), Vec::new(), Budget::default());
        for (place, node) in tree.nodes() {
            let Some(index) = root.nodes[node].mesh else { continue };
            let named = &root.meshes[index.value()];
            let name = root.nodes[node].name.clone().or_else(|| named.name.clone());
            objects.push(name.unwrap_or_else(|| format!("node {node}")));
            let binding = Binding::new(self.source, tree, world, (place, node))?;
            for (p, primitive) in named.primitives.iter().enumerate() {
                let place_name = format!("mesh {}, primitive {p}", index.value());
                let material = self.surface(primitive.material.map(|m| m.value()), warnings)?;
                let surface = &self.surfaces[material].1;
                if surface.invisible {
                    let file = self.source.path.display();
                    warnings.add("invisible", || {
                        format!("{file}: {place_name}: its material cuts all of it away, and it was left out")
                    });
                    continue;
                }
                let object = objects.len() as u32 - 1;
                let target = Target { mesh: &mut mesh, object, material: material as u32, surface, binding: &binding };
                primitive::append(self.source, &place_name, primitive, target, &mut budget, warnings)?;
            }
        }
        Ok((mesh, objects))
    }

    /// The materials of all meshes so far.
    fn materials(&self) -> Vec<Material> {
        self.surfaces.iter().map(|(_, surface)| surface.material.clone()).collect()
    }

    /// The error of a scene without a triangle.
    fn empty(&self, moves: bool, options: &LoadOptions) -> SceneError {
        let invisible = !self.surfaces.is_empty() && self.surfaces.iter().all(|(_, surface)| surface.invisible);
        let what = if invisible {
            "the scene is empty: its materials cut all of it away (alphaMode MASK, alpha below the cutoff)".to_owned()
        } else if moves {
            format!(
                "the scene is empty at frame {}: no node has a mesh with a triangle that has an area in single precision",
                options.frame
            )
        } else {
            "the scene is empty: no node has a mesh with a triangle that has an area in single precision".to_owned()
        };
        let fix = if moves { "take another frame" } else { "a scene needs at least one triangle" };
        SceneError::input(Location::File(self.source.path.clone()), what, fix)
    }

    /// The index of a material of the file among those that are used.
    fn surface(&mut self, index: Option<usize>, warnings: &mut Warnings) -> Result<usize, SceneError> {
        if let Some(known) = self.surfaces.iter().position(|(file, _)| *file == index) {
            return Ok(known);
        }
        let mut all = self.source.document.materials();
        let surface = match index.and_then(|index| all.nth(index)) {
            Some(material) => materials::surface(self.source, &material, &mut self.pictures, warnings)?,
            None => materials::plain(),
        };
        self.surfaces.push((index, surface));
        Ok(self.surfaces.len() - 1)
    }
}
