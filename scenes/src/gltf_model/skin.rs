//! To what the vertices of a mesh are bound: to its node, or to several joints, each by a weight (a skin).

use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::{
    document::Source,
    nodes::{Tree, label},
};
use crate::error::SceneError;

/// Sets of joints and weights that are looked for: four joints each.
const SETS: u32 = 4;

/// To what the vertices of a mesh are bound, and where that stands in the scene.
pub(crate) enum Binding {
    /// Its node.
    Node(DAffine3),
    /// The joints of a skin. Where the node of the mesh stands does not count.
    Joints(Vec<DAffine3>),
}

/// The binding of a primitive's vertices.
pub(crate) struct Bound<'a> {
    binding: &'a Binding,
    sets: Vec<Set>,
}

/// Four joints of each vertex, and how much each counts.
struct Set {
    numbers: Vec<[u32; 4]>,
    weights: Vec<[f32; 4]>,
}

impl Binding {
    /// Of the mesh at a place of the tree, whose nodes stand as `world` says.
    pub fn new(
        source: &Source,
        tree: &Tree,
        world: &[DAffine3],
        (place, node): (usize, usize),
    ) -> Result<Self, SceneError> {
        let root = source.root();
        let Some(index) = root.nodes[node].skin.map(|skin| skin.value()) else { return Ok(Self::Node(world[place])) };
        let (skin, part) = (&root.skins[index], format!("skin {index}"));
        let broken = |what: String| source.bad(part.clone(), what, "export the model again");
        let bind = skin.inverse_bind_matrices.map(|at| source.floats::<16>(at.value())).transpose()?;
        if let Some(bind) = bind.as_ref().filter(|bind| bind.len() < skin.joints.len()) {
            return Err(broken(format!(
                "it has {} joints and {} inverse bind matrices",
                skin.joints.len(),
                bind.len()
            )));
        }
        let joint = |(number, joint): (usize, usize)| {
            let place = tree
                .place(joint)
                .ok_or_else(|| broken(format!("its joint {number}, {}, is not in the scene", label(source, joint))))?;
            let bind = bind.as_ref().map_or(DAffine3::IDENTITY, |bind| {
                DAffine3::from_mat4(DMat4::from_cols_array(&bind[number].map(f64::from)))
            });
            Ok(world[place] * bind)
        };
        skin.joints.iter().map(|joint| joint.value()).enumerate().map(joint).collect::<Result<_, _>>().map(Self::Joints)
    }

    /// Of the `count` vertices of a primitive.
    pub fn of_vertices(
        &self,
        source: &Source,
        place: &str,
        primitive: &Primitive,
        count: usize,
    ) -> Result<Bound<'_>, SceneError> {
        let mut bound = Bound { binding: self, sets: Vec::new() };
        let Self::Joints(joints) = self else { return Ok(bound) };
        let broken = |what: String| source.bad(place, what, "export the model again");
        for set in 0..SETS {
            let accessor = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
            let (numbers, weights) = (accessor(Semantic::Joints(set)), accessor(Semantic::Weights(set)));
            let (Some(numbers), Some(weights)) = (numbers, weights) else { continue };
            let (numbers, weights) = (source.numbers::<4>(numbers)?, source.floats::<4>(weights)?);
            if numbers.len() != count || weights.len() != count {
                let (joints, weights) = (numbers.len(), weights.len());
                return Err(broken(format!("it has {count} positions, {joints} joints and {weights} weights")));
            }
            for (vertex, (numbers, weights)) in numbers.iter().zip(&weights).enumerate() {
                let mut used = numbers.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
                if let Some((number, _)) = used.find(|(number, _)| **number as usize >= joints.len()) {
                    let what = format!("vertex {vertex} has joint {number}, and its skin has {}", joints.len());
                    return Err(broken(what));
                }
            }
            bound.sets.push(Set { numbers, weights });
        }
        Ok(bound)
    }
}

impl Bound<'_> {
    /// Where a vertex stands: with its joints in the mean, by their weights. Weights of few bits add up to one nearly; a vertex without
    /// weights stands as it is stored.
    pub fn stand(&self, vertex: usize) -> DAffine3 {
        let joints = match self.binding {
            Binding::Node(world) => return *world,
            Binding::Joints(joints) => joints,
        };
        let (mut matrix, mut translation, mut sum) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for Set { numbers, weights } in &self.sets {
            let used = numbers[vertex].into_iter().zip(weights[vertex]).filter(|(_, weight)| *weight != 0.0);
            for (number, weight) in used {
                let (joint, weight) = (&joints[number as usize], f64::from(weight));
                matrix += joint.matrix3 * weight;
                translation += joint.translation * weight;
                sum += weight;
            }
        }
        if sum == 0.0 {
            return DAffine3::IDENTITY;
        }
        DAffine3 { matrix3: matrix * (1.0 / sum), translation: translation / sum }
    }
}
