//! A source whose untraced hits hold garbage: who reads one gives himself away.

use rayreel_formats::half::Half3;
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Hit, Radiance, Shadows, Tile};
use rayreel_replay::TileSource;

use crate::random::Random;
use crate::reference::Outcome;

/// `source`, with every hit that `outcome` has not traced replaced by garbage: other hits, objects and shadows, NaN and
/// infinite colours. The second implementation says which: it knows of single hits of a sample.
pub struct Poisoned<'a, S> {
    /// The frames to spoil.
    pub source: &'a S,
    /// What may be read.
    pub outcome: &'a Outcome,
    /// Of the garbage.
    pub seed: u64,
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
        let mut tile = self.source.tile(frame, index)?;
        let rect = tile.rect;
        let mut random = Random(self.seed ^ u64::from(index));
        for sample in 0..rect.len() {
            let (x, y) = (rect.x + sample as u32 % rect.width, rect.y + sample as u32 / rect.width);
            let traced = &self.outcome.traced[y as usize * self.outcome.width + x as usize];
            for (node, _) in tile.tree.sample(sample).zip(traced).filter(|(_, traced)| !**traced) {
                spoil(&mut tile, node, &mut random);
            }
        }
        Ok(tile)
    }
}

/// The shape of the tree stays: a trace with another shape would not be one.
fn spoil(tile: &mut Tile, node: usize, random: &mut Random) {
    // Quiet NaN, infinity, or any finite number.
    let mut half = || [0x7e00, 0x7c00, (random.next() & 0x7bff) as u16][random.remainder(3) as usize];
    let mut colour = || Half3([half(), half(), half()]);
    tile.radiance[node] = Radiance { local: colour(), reflect: colour(), refract: colour() };
    let t = [f32::NAN, f32::INFINITY, -1.0, 0.5][random.remainder(4) as usize];
    // A triangle that is in the trace: a reader would refuse any other.
    let triangle = random.remainder(8);
    tile.hits[node] = Hit { triangle, t, normal: Oct::from_bits(random.next()) };
    tile.tree.nodes[node].hit = random.remainder(2) == 0;
    tile.tree.nodes[node].shadows = Shadows(random.next());
}
