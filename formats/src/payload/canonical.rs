//! Columns as plain bytes, in sample order: what digests hash, what codec 0 packs with zstd, and what `raw_len` counts.

use crate::half::Half3;
use crate::oct::Oct;
use crate::tile::{Column, Hit, MAX_DEPTH, Paths, Radiance, RayClass, RayNode, Shadows, Tile, Tree};

impl Tile {
    /// A column as plain bytes, uncompressed and independent of any codec: what a digest hashes. FORMAT.md gives the
    /// layout.
    pub fn canonical_bytes(&self, column: Column) -> Vec<u8> {
        match column {
            Column::Tree => tree(&self.tree),
            Column::Hits => hits(&self.tree, &self.hits),
            Column::Radiance => radiance(&self.tree, &self.radiance),
            Column::Paths => paths(&self.paths),
        }
    }
}

/// The length of [`Tile::canonical_bytes`], without making them.
pub fn length(tile: &Tile, column: Column) -> u64 {
    match column {
        Column::Tree => tree_length(&tile.tree),
        Column::Hits => hits_length(&tile.tree),
        Column::Radiance => radiance_length(&tile.tree),
        Column::Paths => paths_length(&tile.paths),
    }
}

/// Canonical length of a tree column.
pub fn tree_length(tree: &Tree) -> u64 {
    tree.nodes.iter().map(|n| 1 + 4 * u64::from(n.hit)).sum()
}

/// Canonical length of the hits column on this tree.
pub fn hits_length(tree: &Tree) -> u64 {
    tree.nodes.iter().map(|n| 12 * u64::from(n.hit)).sum()
}

/// Canonical length of the radiance column on this tree.
pub fn radiance_length(tree: &Tree) -> u64 {
    tree.nodes.iter().map(|n| 6 * (1 + u64::from(n.reflect) + u64::from(n.refract))).sum()
}

/// Canonical length of a paths column.
pub fn paths_length(paths: &Paths) -> u64 {
    paths.spans.iter().map(|&(_, length)| 4 + u64::from(length)).sum()
}

/// The tree column: per node, depth first, a byte of flags (1 hit, 2 reflection, 4 refraction), and for a hit the
/// shadow states (u32).
fn tree(tree: &Tree) -> Vec<u8> {
    let mut out = Vec::with_capacity(tree.nodes.len() * 4);
    for node in &tree.nodes {
        out.push(u8::from(node.hit) | u8::from(node.reflect) << 1 | u8::from(node.refract) << 2);
        if node.hit {
            out.extend_from_slice(&node.shadows.0.to_le_bytes());
        }
    }
    out
}

/// Reads [`tree`] back for `samples` samples of at most `lights` lights.
///
/// # Errors
/// Says what is wrong with the bytes.
pub fn parse_tree(bytes: &[u8], samples: usize, lights: usize, max_depth: u32) -> Result<Tree, String> {
    let mut input = Bytes(bytes);
    let mut tree = Tree { first: Vec::with_capacity(samples + 1), nodes: Vec::new() };
    let lights = if lights >= 16 { u32::MAX } else { (1 << (2 * lights)) - 1 };
    for _ in 0..samples {
        tree.first.push(tree.nodes.len() as u32);
        // Classes still to be read, the next one on top.
        let mut open = vec![RayClass::PRIMARY];
        while let Some(class) = open.pop() {
            let flags = input.byte()?;
            let hit = flags & 1 != 0;
            let shadows = Shadows(if hit { input.word()? } else { 0 });
            let node = RayNode { class, hit, reflect: flags & 2 != 0, refract: flags & 4 != 0, shadows };
            let bad_children = (node.reflect || node.refract) && (!hit || class.depth() >= max_depth.min(MAX_DEPTH));
            if flags > 7 || bad_children || shadows.0 & !lights != 0 {
                return Err(format!("node {} has impossible flags", tree.nodes.len()));
            }
            open.extend(node.refract.then(|| class.refraction()));
            open.extend(node.reflect.then(|| class.reflection()));
            tree.nodes.push(node);
        }
    }
    tree.first.push(tree.nodes.len() as u32);
    input.end()?;
    Ok(tree)
}

/// The hits column: per hit, in node order, triangle, bits of `t`, normal (u32 each).
fn hits(tree: &Tree, hits: &[Hit]) -> Vec<u8> {
    let mut out = Vec::with_capacity(hits.len() * 12);
    for (_, hit) in tree.nodes.iter().zip(hits).filter(|(node, _)| node.hit) {
        for word in [hit.triangle, hit.t.to_bits(), hit.normal.to_bits()] {
            out.extend_from_slice(&word.to_le_bytes());
        }
    }
    out
}

/// Reads [`hits`] back, on a tree of `triangles` triangles.
///
/// # Errors
/// Says what is wrong with the bytes.
pub fn parse_hits(bytes: &[u8], tree: &Tree, triangles: usize) -> Result<Vec<Hit>, String> {
    let mut input = Bytes(bytes);
    let mut out = Vec::with_capacity(tree.nodes.len());
    for node in &tree.nodes {
        if !node.hit {
            out.push(Hit::MISS);
            continue;
        }
        let (triangle, t, normal) = (input.word()?, f32::from_bits(input.word()?), Oct::from_bits(input.word()?));
        if triangle as usize >= triangles {
            return Err(format!("a hit on triangle {triangle} of {triangles}"));
        }
        out.push(Hit { triangle, t, normal });
    }
    input.end()?;
    Ok(out)
}

/// The radiance column: per node the local colour, then the weights of the children it has (3 half floats each).
fn radiance(tree: &Tree, radiance: &[Radiance]) -> Vec<u8> {
    let mut out = Vec::with_capacity(radiance.len() * 8);
    let mut push = |value: Half3| value.0.iter().for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
    for (node, values) in tree.nodes.iter().zip(radiance) {
        push(values.local);
        if node.reflect {
            push(values.reflect);
        }
        if node.refract {
            push(values.refract);
        }
    }
    out
}

/// Reads [`radiance`] back.
///
/// # Errors
/// Says what is wrong with the bytes.
pub fn parse_radiance(bytes: &[u8], tree: &Tree) -> Result<Vec<Radiance>, String> {
    let mut input = Bytes(bytes);
    let mut triple = |there: bool| {
        if !there {
            return Ok(Half3::ZERO);
        }
        let value = Half3([input.half()?, input.half()?, input.half()?]);
        if value.is_valid() { Ok(value) } else { Err("a colour is negative or not finite".to_string()) }
    };
    let mut out = Vec::with_capacity(tree.nodes.len());
    for node in &tree.nodes {
        out.push(Radiance { local: triple(true)?, reflect: triple(node.reflect)?, refract: triple(node.refract)? });
    }
    input.end()?;
    Ok(out)
}

/// The paths column: the length of every path in ray order (u32 each), then all steps in ray order, a byte each.
fn paths(paths: &Paths) -> Vec<u8> {
    let steps: usize = paths.spans.iter().map(|&(_, length)| length as usize).sum();
    let mut out = Vec::with_capacity(4 * paths.spans.len() + steps);
    for &(_, length) in &paths.spans {
        out.extend_from_slice(&length.to_le_bytes());
    }
    for ray in 0..paths.spans.len() {
        out.extend_from_slice(paths.ray(ray));
    }
    out
}

/// Reads [`paths`] back for `rays` rays. Whether the steps fit the tree is for the walker to say.
///
/// # Errors
/// Says what is wrong with the bytes.
pub fn parse_paths(bytes: &[u8], rays: usize) -> Result<Paths, String> {
    let mut input = Bytes(bytes);
    let mut spans = Vec::with_capacity(rays.min(bytes.len() / 4));
    let mut start = 0u64;
    for _ in 0..rays {
        let length = input.word()?;
        spans.push((start as u32, length));
        start += u64::from(length);
        if start > bytes.len() as u64 {
            return Err("the paths are longer than their column".into());
        }
        if start > u64::from(u32::MAX) {
            return Err("the paths have more than 2^32 - 1 steps".into());
        }
    }
    let steps = input.0.to_vec();
    if steps.len() as u64 != start || steps.iter().any(|&s| s > crate::tile::step::PASS) {
        return Err("the paths do not fill their column with steps".into());
    }
    Ok(Paths { steps, spans })
}

/// Little-endian fields, one after the other.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or("the column ends early")?;
        self.0 = rest;
        Ok(*head)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take::<1>().map(|b| b[0])
    }

    fn half(&mut self) -> Result<u16, String> {
        self.take().map(u16::from_le_bytes)
    }

    fn word(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    fn end(&self) -> Result<(), String> {
        if self.0.is_empty() { Ok(()) } else { Err(format!("{} bytes left over", self.0.len())) }
    }
}
