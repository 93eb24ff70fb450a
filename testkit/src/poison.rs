//! A source whose untraced hits hold garbage: who reads one gives himself away.

use rayreel_formats::half::Half3;
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Hit, Radiance, Shadows, Tile};
use rayreel_replay::TileSource;

use crate::random::Random;
use crate::reference::Outcome;

/// `source`, with every hit that an outcome has not traced replaced by garbage: other hits, objects and shadows, NaN and
/// infinite colours. The second implementation says which: it knows of single hits of a sample.
pub struct Poisoned<'a, S> {
    /// The frames to spoil.
    pub source: &'a S,
    /// What may be read, by frame: the last stands for all that follow.
    pub outcomes: Vec<(u32, &'a Outcome)>,
    /// Of the garbage.
    pub seed: u64,
}

impl<'a, S> Poisoned<'a, S> {
    /// Of one frame.
    pub fn new(source: &'a S, outcome: &'a Outcome, seed: u64) -> Self {
        Self { source, outcomes: vec![(0, outcome)], seed }
    }
}

impl<S: TileSource> TileSource for Poisoned<'_, S> {
    fn meta(&self) -> &Meta {
        self.source.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.source.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.source.camera(frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        let before = self.outcomes.partition_point(|(number, _)| *number <= frame);
        let (_, outcome) = self.outcomes[before.max(1) - 1];
        Ok(poisoned(self.source.tile(frame, index)?, outcome, self.seed ^ u64::from(frame) << 32 ^ u64::from(index)))
    }
}

fn poisoned(mut tile: Tile, outcome: &Outcome, seed: u64) -> Tile {
    let (rect, mut random) = (tile.rect, Random(seed));
    for sample in 0..rect.len() {
        let (x, y) = (rect.x + sample as u32 % rect.width, rect.y + sample as u32 / rect.width);
        let traced = &outcome.traced[y as usize * outcome.width + x as usize];
        for (node, traced) in tile.tree.sample(sample).zip(traced) {
            if !traced.hit {
                spoil(&mut tile, node, &mut random);
            } else if traced.stood_for {
                // Its rays met what they met; its colour for these shadows is another one.
                tile.radiance[node].local = garbage(&mut random);
            }
        }
    }
    tile
}

/// Quiet NaN, infinity, or any finite number.
fn garbage(random: &mut Random) -> Half3 {
    let mut half = || [0x7e00, 0x7c00, (random.next() & 0x7bff) as u16][random.remainder(3) as usize];
    Half3([half(), half(), half()])
}

/// The shape of the tree stays: a trace with another shape would not be one.
fn spoil(tile: &mut Tile, node: usize, random: &mut Random) {
    tile.radiance[node] = Radiance { local: garbage(random), reflect: garbage(random), refract: garbage(random) };
    let t = [f32::NAN, f32::INFINITY, -1.0, 0.5][random.remainder(4) as usize];
    // A triangle that is in the trace: a reader would refuse any other.
    let triangle = random.remainder(8);
    tile.hits[node] = Hit { triangle, t, normal: Oct::from_bits(random.next()) };
    tile.tree.nodes[node].hit = random.remainder(2) == 0;
    tile.tree.nodes[node].shadows = Shadows(random.next());
}
