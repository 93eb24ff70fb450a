//! Where the work of a frame lies, as far as its trace tells before anything is replayed: in tiles by their rays.
//!
//! Windows are chosen in work, not in tiles. A window in the sky is long and takes no time, one in glass is short and says as much about the
//! frame: each stands for the same part of the work. The rays of `full` say it for all policies, so all have their windows at the same
//! places of the picture, and what they share cancels in ratios.

/// A frame's tiles, laid out by their work. Work is counted in mean tiles: a frame of as many tiles has as much work.
#[derive(Clone, Debug)]
pub struct WorkLine {
    /// The work before each tile, and all of it at the end.
    sums: Vec<f64>,
}

impl WorkLine {
    /// Tiles that trace so many rays each, in order, on a machine that works on `slots` of them at a time.
    pub fn new(rays: &[u64], slots: usize) -> Self {
        // While so many tiles are done, parts of tiles included, half of the slots are at tiles before that, and half behind.
        let reach = slots / 2;
        let under_way = |tile: usize| {
            let tiles = &rays[tile.saturating_sub(reach)..(tile + reach + 1).min(rays.len())];
            tiles.iter().sum::<u64>() as f64 / tiles.len() as f64
        };
        let work: Vec<f64> = (0..rays.len()).map(under_way).collect();
        let mean = work.iter().sum::<f64>() / work.len().max(1) as f64;
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for work in work {
            // Where nothing is traced, all tiles are alike.
            sum += if mean > 0.0 { work / mean } else { 1.0 };
            sums.push(sum);
        }
        Self { sums }
    }

    /// The work before so many tiles are done, parts of tiles included.
    pub fn work_at(&self, tiles: f64) -> f64 {
        let tile = (tiles.max(0.0) as usize).min(self.sums.len().saturating_sub(2));
        let Some(&[before, after]) = self.sums.get(tile..tile + 2) else { return 0.0 };
        before + (tiles - tile as f64) * (after - before)
    }

    /// How many tiles are done, parts of tiles included, after so much work.
    pub fn tiles_at(&self, work: f64) -> f64 {
        let tile = self.sums.partition_point(|sum| *sum <= work).clamp(1, self.sums.len().saturating_sub(1).max(1)) - 1;
        let Some(&[before, after]) = self.sums.get(tile..tile + 2) else { return 0.0 };
        let part = if after > before { (work - before) / (after - before) } else { 0.0 };
        tile as f64 + part.clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_that_trace_alike_are_as_they_were() {
        for rays in [0, 1000] {
            let line = WorkLine::new(&[rays; 40], 8);
            for at in [0.0, 0.5, 7.25, 39.0, 40.0] {
                assert!((line.work_at(at) - at).abs() < 1e-9 && (line.tiles_at(at) - at).abs() < 1e-9, "{at}");
            }
        }
    }

    #[test]
    fn as_much_work_is_fewer_tiles_where_they_trace_more() {
        // A machine of one slot, so that every tile stands for itself: 30 of sky, 10 of glass, which is half of all rays.
        let rays: Vec<u64> = (0..40).map(|tile| if tile < 30 { 1000 } else { 3000 }).collect();
        let line = WorkLine::new(&rays, 1);
        assert!((line.work_at(40.0) - 40.0).abs() < 1e-9, "all of the work is as many mean tiles");
        assert!((line.work_at(30.0) - 20.0).abs() < 1e-9);
        assert!((line.tiles_at(2.0) - 3.0).abs() < 1e-9, "a mean tile of work is one and a half of sky");
        assert!((line.tiles_at(22.0) - 31.0).abs() < 1e-9, "and half a tile of glass");
    }

    #[test]
    fn there_and_back() {
        let rays: Vec<u64> = (0..100).map(|tile| 500 + tile * tile % 37 * 200).collect();
        let line = WorkLine::new(&rays, 8);
        for at in 0..1000 {
            let tiles = f64::from(at) / 10.0;
            assert!((line.tiles_at(line.work_at(tiles)) - tiles).abs() < 1e-6, "{tiles}");
        }
    }

    #[test]
    fn what_is_under_way_beside_a_tile_counts() {
        let mut rays = [1000; 64];
        rays[32] = 9 * 1000;
        let (alone, among) = (WorkLine::new(&rays, 1), WorkLine::new(&rays, 8));
        let of = |line: &WorkLine, tile: f64| line.work_at(tile + 1.0) - line.work_at(tile);
        assert!((of(&alone, 32.0) / of(&alone, 20.0) - 9.0).abs() < 1e-9);
        assert!(
            (of(&among, 32.0) / of(&among, 20.0) - 17.0 / 9.0).abs() < 1e-9,
            "one of nine tiles traces nine times as much"
        );
        assert!(
            (of(&among, 28.0) / of(&among, 27.0) - 17.0 / 9.0).abs() < 1e-9,
            "four tiles away it is under way, five it is not"
        );
    }

    #[test]
    fn a_frame_without_tiles_has_no_work() {
        let line = WorkLine::new(&[], 8);
        assert_eq!((line.work_at(1.0), line.tiles_at(1.0)), (0.0, 0.0));
    }
}
