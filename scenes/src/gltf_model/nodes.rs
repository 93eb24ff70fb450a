//! The tree of nodes: which are in the scene, and where each stands at a time.

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::scene::Node;

use super::{
    animation::{Animations, Pose},
    document::Source,
};
use crate::{error::SceneError, warnings::Warnings};

/// A place without a node above it.
const ROOT: usize = usize::MAX;

/// How a node stands in its parent: as parts, which can be animated, or as a matrix.
#[derive(Clone, Copy)]
enum Stand {
    Parts(Pose),
    Matrix(DAffine3),
}

/// A node of the scene.
struct Place {
    node: usize,
    parent: usize,
    stand: Stand,
}

/// The nodes of the scene that the file shows, parents before children.
pub(crate) struct Tree {
    places: Vec<Place>,
    /// The place of each node of the file that is in the scene.
    of_node: Vec<Option<usize>>,
}

impl Tree {
    /// Collects the nodes of the file's scene, in the order of the file.
    pub fn new(source: &Source, animations: &Animations, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let root = source.root();
        let mut of_node = vec![None; root.nodes.len()];
        let mut places: Vec<Place> = Vec::new();
        let mut todo: Vec<(usize, usize)> = roots(source, warnings).into_iter().rev().map(|n| (n, ROOT)).collect();
        while let Some((index, parent)) = todo.pop() {
            let node = &root.nodes[index];
            if of_node[index].replace(places.len()).is_some() {
                return Err(source.bad(
                    label(source, index),
                    "it is reached twice: nodes must form a tree",
                    "export the model again",
                ));
            }
            let stand = stand(source, index, node, animations)?;
            let children = node.children.iter().flatten().rev();
            todo.extend(children.map(|child| (child.value(), places.len())));
            places.push(Place { node: index, parent, stand });
        }
        Ok(Self { places, of_node })
    }

    /// The file's node at each place.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, usize)> {
        self.places.iter().enumerate().map(|(place, p)| (place, p.node))
    }

    /// The place of a node of the file; nothing if it is not in the scene.
    pub fn place(&self, node: usize) -> Option<usize> {
        self.of_node.get(node).copied().flatten()
    }

    /// Where every place stands in the scene at a time, in seconds.
    pub fn world(&self, animations: &Animations, time: f64) -> Vec<DAffine3> {
        let mut world: Vec<DAffine3> = Vec::with_capacity(self.places.len());
        for place in &self.places {
            let local = local(place, animations, time);
            world.push(if place.parent == ROOT { local } else { world[place.parent] * local });
        }
        world
    }

    /// Where one place stands.
    pub fn world_of(&self, place: usize, animations: &Animations, time: f64) -> DAffine3 {
        let mut up = Vec::new();
        let mut at = place;
        while at != ROOT {
            up.push(local(&self.places[at], animations, time));
            at = self.places[at].parent;
        }
        up.into_iter().rev().reduce(|above, below| above * below).unwrap_or(DAffine3::IDENTITY)
    }

    /// Whether a place, or what it hangs on, is animated.
    pub fn moves(&self, place: usize, animations: &Animations) -> bool {
        let mut at = place;
        while at != ROOT {
            if animations.moves(self.places[at].node) {
                return true;
            }
            at = self.places[at].parent;
        }
        false
    }
}

/// How messages call a node.
pub(crate) fn label(source: &Source, index: usize) -> String {
    let name = source.root().nodes.get(index).and_then(|node| node.name.as_deref());
    name.map_or_else(|| format!("node {index}"), |name| format!("node {index} `{name}`"))
}

/// The nodes at the top: those of the default scene, else of the first, else all that hang on nothing.
fn roots(source: &Source, warnings: &mut Warnings) -> Vec<usize> {
    let root = source.root();
    let shown = root.scene.map_or(0, |scene| scene.value());
    for _ in 1..root.scenes.len() {
        warnings.add("scenes", || {
            format!(
                "{}: scene {shown} of {} is shown; other scenes are not read",
                source.path.display(),
                root.scenes.len()
            )
        });
    }
    if let Some(scene) = root.scenes.get(shown) {
        return scene.nodes.iter().map(|node| node.value()).collect();
    }
    let mut hangs = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        hangs[child.value()] = true;
    }
    (0..root.nodes.len()).filter(|node| !hangs[*node]).collect()
}

fn stand(source: &Source, index: usize, node: &Node, animations: &Animations) -> Result<Stand, SceneError> {
    let broken = |what: &str| Err(source.bad(label(source, index), what, "export the model again"));
    if let Some(m) = node.matrix {
        if animations.moves(index) {
            return broken("it has a matrix and is animated: only translation, rotation and scale can be");
        }
        if m.iter().any(|x| !x.is_finite()) {
            return broken("its matrix is not finite");
        }
        if [m[3], m[7], m[11], m[15] - 1.0].iter().any(|x| x.abs() > 1e-6) {
            return broken("the last row of its matrix is not 0 0 0 1");
        }
        let column = |c: usize| DVec3::new(m[4 * c].into(), m[4 * c + 1].into(), m[4 * c + 2].into());
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        return Ok(Stand::Matrix(DAffine3 { matrix3, translation: column(3) }));
    }
    let triple = |given: Option<[f32; 3]>, otherwise: f64| {
        given.map_or(DVec3::splat(otherwise), |v| DVec3::from_array(v.map(f64::from)))
    };
    let rotation = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0.map(f64::from));
    let pose = Pose { translation: triple(node.translation, 0.0), rotation, scale: triple(node.scale, 1.0) };
    if !(pose.translation.is_finite() && pose.scale.is_finite() && rotation.iter().all(|x| x.is_finite())) {
        return broken("its translation, rotation or scale is not finite");
    }
    Ok(Stand::Parts(pose))
}

fn local(place: &Place, animations: &Animations, time: f64) -> DAffine3 {
    match place.stand {
        Stand::Matrix(matrix) => matrix,
        Stand::Parts(pose) => affine(&animations.pose(place.node, pose, time)),
    }
}

/// The transform of a pose. A rotation of any length is read as its direction; without one nothing turns.
fn affine(pose: &Pose) -> DAffine3 {
    let [x, y, z, w] = pose.rotation;
    let square = x * x + y * y + z * z + w * w;
    let s = if square > 0.0 { 2.0 / square } else { 0.0 };
    let matrix3 = DMat3::from_cols(
        DVec3::new(1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)) * pose.scale.x,
        DVec3::new(s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)) * pose.scale.y,
        DVec3::new(s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)) * pose.scale.z,
    );
    DAffine3 { matrix3, translation: pose.translation }
}
