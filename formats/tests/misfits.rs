//! A tile that is not of one piece is refused when it is coded, with its frame, tile and column: no column is written
//! that would read as something else.

mod trace_support;

use rayreel_formats::bvh::Child;
use rayreel_formats::container::EncodedChunk;
use rayreel_formats::tile::{Column, Tile, step};
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec, Trace};
use rayreel_formats::{Limits, Result};
use trace_support::whole::Content;

/// A tile of another frame and number than 0. The leftmost leaf of its tree holds triangles, one of which is opaque.
fn content() -> Content {
    let suits = |content: &Content| leftmost(content).1.triangles().any(|t| !content.bvh.material(t).may_pass(false));
    let random = |seed| Content::random(seed, (12, 5), 6, 9, 2, 2);
    let mut content = (0..).map(random).find(suits).expect("some seed suits");
    content.tiles.retain(|tile| tile.frame == content.meta.first_frame + 1 && tile.index == 1);
    content
}

/// Down the left side: the steps to the first leaf, and the leaf. The right child of the root is put aside.
fn leftmost(content: &Content) -> (Vec<u8>, Child) {
    let mut child = content.bvh.nodes[0].children[0];
    let mut down = vec![step::LEFT_FIRST];
    while !child.is_leaf() {
        child = content.bvh.nodes[child.node()].children[0];
        down.push(step::LEFT);
    }
    (down, child)
}

fn encode(content: &Content, tile: &Tile) -> Result<EncodedChunk> {
    let (topology, limits) = (BvhTopology::new(&content.bvh), Limits::default());
    let camera = &content.cameras[(tile.frame - content.meta.first_frame) as usize];
    let codec = TileCodec { meta: &content.meta, bvh: &content.bvh, topology: &topology, camera, limits: &limits };
    codec.encode(tile, Codec::Context, &mut Scratch::default())
}

#[track_caller]
fn assert_refused(content: &Content, change: impl FnOnce(&mut Tile), column: Column, why: &str) {
    let mut tile = content.tiles[0].clone();
    change(&mut tile);
    let error = encode(content, &tile).expect_err("the tile is not of one piece").to_string();
    let place = format!("frame {}, tile {}: column {}: ", tile.frame, tile.index, column.name());
    assert!(error.starts_with(&place) && error.contains(why), "{error}");
}

/// Gives a ray another path.
fn set(tile: &mut Tile, ray: usize, path: &[u8]) {
    tile.paths.spans[ray] = (tile.paths.steps.len() as u32, path.len() as u32);
    tile.paths.steps.extend_from_slice(path);
}

#[test]
fn a_path_that_does_not_fit_the_tree_is_refused() {
    let content = content();
    let first = content.tiles[0].paths.ray(0).to_vec();
    let refused = |path: &[u8], why: &str| {
        assert_refused(&content, |tile| set(tile, 0, path), Column::Paths, "the path of ray 0 does not fit the tree: ");
        assert_refused(&content, |tile| set(tile, 0, path), Column::Paths, why);
    };
    refused(&[], "it ends at an inner node");
    refused(&[step::POP], "no outcome of its boxes");
    refused(&[255], "no outcome of its boxes");
    refused(&[&first[..], &[step::NONE]].concat(), "it goes on where the traversal ends");
    let (down, leaf) = leftmost(&content);
    refused(&down, "it ends in a leaf");
    refused(&[&down[..], &[step::NONE]].concat(), "no triangle test");
    let tests = |outcome: u8| [&down[..], &vec![outcome; leaf.count()]].concat();
    refused(&tests(step::MISS), "where a child is popped");
    refused(&[&tests(step::MISS)[..], &[step::CULLED]].concat(), "nothing can hide it");
    refused(&tests(step::PASS), "lets no ray through");
}

/// Whatever one step is changed to: the tile is refused, or reads as what was written.
#[test]
fn a_changed_step_is_refused_or_comes_back() {
    let content = content();
    let steps = content.tiles[0].paths.steps.len();
    let (mut refused, mut written) = (0, 0);
    for at in 0..steps {
        for value in 0..=step::PASS + 1 {
            let mut changed = Content { tiles: content.tiles.clone(), ..clone_scene(&content) };
            changed.tiles[0].paths.steps[at] = value;
            if encode(&changed, &changed.tiles[0]).is_err() {
                refused += 1;
                continue;
            }
            written += 1;
            let trace = Trace::from_bytes(changed.bytes(|_| Codec::Context), Limits::default()).expect("it opens");
            let tile = &changed.tiles[0];
            let back = trace.tile(tile.frame, tile.index, &[Column::Paths]).expect("it decodes");
            assert!(back.paths == tile.paths, "step {at} as {value}");
        }
    }
    assert!(refused > steps && written >= steps, "{refused} refused, {written} written, of {steps} steps");
}

fn clone_scene(content: &Content) -> Content {
    let (meta, bvh, cameras) = (content.meta.clone(), content.bvh.clone(), content.cameras.clone());
    Content { meta, bvh, cameras, tiles: Vec::new() }
}

#[test]
fn columns_that_do_not_fit_the_tree_are_refused() {
    let content = content();
    let triangles = content.bvh.triangles.len() as u32;
    let hit = content.tiles[0].tree.nodes.iter().position(|node| node.hit).expect("a hit");
    assert_refused(&content, |tile| tile.rect.height += 1, Column::Tree, "samples");
    assert_refused(&content, |tile| tile.hits[hit].triangle = triangles, Column::Hits, "a hit on triangle");
    assert_refused(&content, |tile| tile.hits.truncate(1), Column::Hits, "nodes");
    assert_refused(&content, |tile| tile.radiance.clear(), Column::Radiance, "it has 0 entries");
    assert_refused(&content, |tile| tile.paths.spans.truncate(1), Column::Paths, "rays");
    assert_refused(&content, |tile| tile.paths.spans[3] = (u32::MAX, 1), Column::Paths, "ray 3 is not among");
}
