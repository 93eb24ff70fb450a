//! Tiles, and which of their samples are looked at.

use rayreel_formats::scene::Rect;
use rayreel_replay::policy::Refine;

use crate::recorded::Frame;

/// A tile: its samples, its block and its factor on the colour limit.
pub struct Area {
    pub x0: usize,
    pub y0: usize,
    pub x1: usize,
    pub y1: usize,
    pub n: usize,
    pub relax: f64,
    /// It relies on the frame before.
    pub is_trusted: bool,
}

/// True for a multiple of the block and for the last one.
pub fn on(at: usize, n: usize, last: usize) -> bool {
    at.is_multiple_of(n) || at == last
}

impl Area {
    pub fn new(rect: Rect, (block, relax): (u32, f64)) -> Self {
        let (x0, y0) = (rect.x as usize, rect.y as usize);
        Self {
            x0,
            y0,
            x1: x0 + rect.width as usize,
            y1: y0 + rect.height as usize,
            n: block as usize,
            relax,
            is_trusted: false,
        }
    }

    pub fn samples(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (x0, x1) = (self.x0, self.x1);
        (self.y0..self.y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)))
    }

    /// Rounds of one step: one, or as often as the block can be halved.
    pub fn levels(&self, refine: Refine) -> u8 {
        let mut levels = 0;
        let mut gap = self.n;
        while gap > 1 {
            gap = gap.div_ceil(2);
            levels += 1;
        }
        if refine == Refine::Direct { 1 } else { levels }
    }
}

/// The samples outside a tile that its steps look at: on the closing column those in R-rows of the tile and of the corner, on
/// the closing row all.
pub fn border(area: &Area, frame: &Frame) -> Vec<(usize, usize)> {
    let mut list = Vec::new();
    if area.x1 < frame.width {
        for y in area.y0..=area.y1 {
            if y < frame.height && on(y, area.n, frame.height - 1) {
                list.push((area.x1, y));
            }
        }
    }
    if area.y1 < frame.height {
        list.extend((area.x0..area.x1).map(|x| (x, area.y1)));
    }
    list
}
