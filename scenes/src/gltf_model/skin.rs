//! Where vertices stand: with their node, or with several joints, each by its weight (a skin).

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

/// Where the vertices of a mesh stand in the scene.
pub(crate) enum Stand {
    /// With the node.
    Node(DAffine3),
    /// With the joints of a skin. Where the node of the mesh stands does not count.
    Joints(Vec<DAffine3>),
}

impl Stand {
    /// Of the mesh at a place of the tree, whose nodes stand as `world` says.
    pub fn of(source: &Source, tree: &Tree, world: &[DAffine3], place: usize, node: usize) -> Result<Self, SceneError> {
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

    /// Where each of the `count` vertices of a primitive stands; one for all with a node.
    pub fn of_vertices(
        &self,
        source: &Source,
        place: &str,
        primitive: &Primitive,
        count: usize,
    ) -> Result<Vec<DAffine3>, SceneError> {
        let joints = match self {
            Self::Node(world) => return Ok(vec![*world]),
            Self::Joints(joints) => joints,
        };
        let broken = |what: String| source.bad(place, what, "export the model again");
        let mut sums = vec![(DMat3::ZERO, DVec3::ZERO, 0.0); count];
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
                for (&number, &weight) in numbers.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                    let joint = joints.get(number as usize).ok_or_else(|| {
                        broken(format!("vertex {vertex} has joint {number}, and its skin has {}", joints.len()))
                    })?;
                    let (weight, (matrix, translation, sum)) = (f64::from(weight), &mut sums[vertex]);
                    *matrix += joint.matrix3 * weight;
                    *translation += joint.translation * weight;
                    *sum += weight;
                }
            }
        }
        // Weights of few bits add up to one nearly. A vertex without weights stands as it is stored.
        let mean = |(matrix, translation, sum): (DMat3, DVec3, f64)| {
            let all = DAffine3 { matrix3: matrix * (1.0 / sum), translation: translation / sum };
            if sum == 0.0 { DAffine3::IDENTITY } else { all }
        };
        Ok(sums.into_iter().map(mean).collect())
    }
}
