//! Which tiles may rely on the history: those in which it was right of late.

use super::HistoryRules;
use super::lights::LightChecks;
use crate::policy::view::TileView;

/// By tile what checks found, the older the less.
#[derive(Clone, Debug)]
pub struct Trust {
    limit: f64,
    tiles: Vec<LightChecks>,
}

impl Trust {
    /// All tiles are trusted.
    pub fn new(rules: &HistoryRules, tiles: u32) -> Self {
        Self { limit: rules.trust, tiles: vec![LightChecks::default(); tiles as usize] }
    }

    /// All tiles are trusted again.
    pub fn forget(&mut self) {
        self.tiles.fill(LightChecks::default());
    }

    /// Whether a tile may rely on the history.
    pub fn of(&self, tile: u32) -> bool {
        let LightChecks { lights, mistaken } = self.tiles[tile as usize];
        f64::from(mistaken) <= self.limit * f64::from(lights)
    }

    /// Takes note of a tile that is decided: what was found before counts half.
    pub fn learn(&mut self, view: &TileView) {
        let (sum, new) = (&mut self.tiles[view.index() as usize], view.light_checks());
        *sum = LightChecks { lights: sum.lights / 2 + new.lights, mistaken: sum.mistaken / 2 + new.mistaken };
    }
}
