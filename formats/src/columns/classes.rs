//! The order in which columns are coded: class by class, and within a class row by row, so that a ray's neighbours in
//! the image are its context (`rows.rs`).

use crate::scene::Rect;
use crate::tile::{RayClass, Tree};

/// The nodes of one class, in sample order.
#[derive(Clone, Debug)]
pub struct ClassRays {
    /// The class.
    pub class: RayClass,
    /// `(sample, node)`, ascending.
    pub rays: Vec<(u32, u32)>,
}

/// The order in which the columns of a tile are coded, with the trees that it is taken from.
#[derive(Debug)]
pub struct CodingOrder<'a> {
    /// The ray trees.
    pub tree: &'a Tree,
    /// The tile's samples.
    pub rect: Rect,
    /// The classes of the trees, ascending.
    pub classes: Vec<ClassRays>,
}

impl<'a> CodingOrder<'a> {
    /// The coding order of a tile.
    pub fn new(tree: &'a Tree, rect: Rect) -> Self {
        Self { tree, rect, classes: classes(tree) }
    }
}

/// All classes of a tree, ascending: a parent's class stands before its children's.
fn classes(tree: &Tree) -> Vec<ClassRays> {
    let mut found: Vec<ClassRays> = Vec::new();
    // Per class its place in `found`, plus one; 0 where it was not found yet.
    let mut place: Vec<u16> = Vec::new();
    for sample in 0..tree.samples() {
        for node in tree.sample(sample) {
            let class = tree.nodes[node].class;
            let slot = class.0 as usize;
            if place.len() <= slot {
                place.resize(slot + 1, 0);
            }
            if place[slot] == 0 {
                found.push(ClassRays { class, rays: Vec::new() });
                place[slot] = found.len() as u16;
            }
            found[place[slot] as usize - 1].rays.push((sample as u32, node as u32));
        }
    }
    found.sort_by_key(|c| c.class);
    found
}
