//! Errors tile by tile: a mean over the picture hides one spoilt corner, the worst tile does not.

use rayreel_formats::scene::Meta;

use super::Srgb8;
use super::psnr::SquaredError;
use crate::error::Result;

/// The tile grid of a trace in pixels. A pixel whose samples lie in several tiles belongs to that of its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    /// Tile edge, samples.
    pub tile: u32,
    /// Samples per pixel and axis.
    pub samples: u32,
    /// Columns of tiles.
    pub columns: u32,
    /// Rows of tiles.
    pub rows: u32,
}

impl TileGrid {
    /// The grid of a trace.
    pub fn of(meta: &Meta) -> Self {
        let (columns, rows) = meta.tile_grid();
        Self { tile: meta.tile, samples: meta.samples, columns, rows }
    }

    /// Column (or row) of the tile in which pixel column (or row) `at` lies.
    fn tile_of(&self, at: u32) -> u32 {
        at * self.samples / self.tile
    }
}

/// The squared error of each tile, row by row.
///
/// # Errors
/// When the sizes differ.
///
/// # Panics
/// When the pictures are larger than the grid.
pub fn tile_errors(a: &Srgb8, b: &Srgb8, grid: TileGrid) -> Result<Vec<SquaredError>> {
    a.same_size(b)?;
    let mut errors = vec![SquaredError::default(); grid.columns as usize * grid.rows as usize];
    let columns: Vec<usize> = (0..a.width).map(|x| grid.tile_of(x) as usize).collect();
    let width = (a.width as usize).max(1);
    for (y, (a, b)) in (0..).zip(a.pixels.chunks_exact(width).zip(b.pixels.chunks_exact(width))) {
        let row = &mut errors[(grid.tile_of(y) * grid.columns) as usize..][..grid.columns as usize];
        for (&column, (a, b)) in columns.iter().zip(a.iter().zip(b)) {
            let squared: u32 = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum();
            row[column].sum += u64::from(squared);
            row[column].values += 3;
        }
    }
    Ok(errors)
}

/// The tile with the largest mean error, the first of equals; `None` if none differs.
pub fn worst(errors: &[SquaredError]) -> Option<(u32, SquaredError)> {
    let differing = (0..).zip(errors).filter(|(_, error)| error.sum > 0);
    differing.fold(None, |worst: Option<(u32, SquaredError)>, (tile, &error)| match worst {
        Some((_, most)) if !error.is_worse_than(most) => worst,
        _ => Some((tile, error)),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::image::psnr::squared_error;

    fn grid(size: (u32, u32), samples: u32, tile: u32) -> TileGrid {
        let [columns, rows] = [size.0, size.1].map(|edge| (edge * samples).div_ceil(tile));
        TileGrid { tile, samples, columns, rows }
    }

    /// Tile by tile, looking at every pixel of the picture for each.
    fn brute_force(a: &Srgb8, b: &Srgb8, grid: TileGrid) -> Vec<SquaredError> {
        let (width, mut errors) = (a.width, Vec::new());
        for (row, column) in (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| (row, column))) {
            let mut error = SquaredError::default();
            for (i, (a, b)) in (0..).zip(a.pixels.iter().zip(&b.pixels)) {
                let (x, y) = (i % width * grid.samples, i / width * grid.samples);
                let inside = |at: u32, tile: u32| (tile * grid.tile..(tile + 1) * grid.tile).contains(&at);
                if inside(x, column) && inside(y, row) {
                    error.values += 3;
                    error.sum += (0..3).map(|c| (i64::from(a[c]) - i64::from(b[c])).pow(2) as u64).sum::<u64>();
                }
            }
            errors.push(error);
        }
        errors
    }

    proptest! {
        #[test]
        fn as_by_brute_force(
            width in 1u32..20, height in 1u32..20, samples in 1u32..4, tile in 1u32..12,
            codes in prop::collection::vec((0u8..4, any::<bool>()), 400),
        ) {
            let mut a = Srgb8 { width, height, pixels: vec![[9; 3]; (width * height) as usize] };
            let b = a.clone();
            for (pixel, &(code, differs)) in a.pixels.iter_mut().zip(&codes) {
                pixel[usize::from(code) % 3] += if differs { code } else { 0 };
            }
            let grid = grid((width, height), samples, tile);
            let errors = tile_errors(&a, &b, grid).unwrap();
            let expected = brute_force(&a, &b, grid);
            prop_assert_eq!(&errors, &expected);
            prop_assert_eq!(errors.iter().map(|e| e.sum).sum::<u64>(), squared_error(&a, &b).unwrap());
            let mean = |e: &SquaredError| e.sum as f64 / e.values.max(1) as f64;
            let most = errors.iter().map(mean).fold(0.0, f64::max);
            match worst(&errors) {
                None => prop_assert_eq!(most, 0.0),
                Some((tile, error)) => {
                    prop_assert_eq!(error, errors[tile as usize]);
                    prop_assert!(mean(&error) >= most);
                    prop_assert!(errors[..tile as usize].iter().all(|e| mean(e) < most), "the first of equals");
                }
            }
        }
    }
}
