//! Sheets: grids with cells left out, and panes with a thickness.

use glam::DVec3;

use crate::modelling::part::Part;

/// A grid of `rows` x `columns` points of which only the cells that `keep(row, column)` names exist; the
/// front is as in [`Part::grid`].
#[must_use]
pub fn sheet(
    rows: usize,
    columns: usize,
    keep: impl Fn(usize, usize) -> bool,
    surface: impl Fn(usize, usize) -> DVec3,
) -> Part {
    let mut part = Part::grid(rows, columns, false, surface);
    let mut cell = 0;
    // The grid has two triangles a cell, row by row.
    part.triangles.retain(|_| {
        let (row, column) = (cell / 2 / (columns - 1), cell / 2 % (columns - 1));
        cell += 1;
        keep(row, column)
    });
    part
}

/// A closed pane: `outer` is its front, `inner` its back, joined round the edge.
#[must_use]
pub fn pane(
    rows: usize,
    columns: usize,
    outer: impl Fn(usize, usize) -> DVec3,
    inner: impl Fn(usize, usize) -> DVec3,
) -> Part {
    let edge: Vec<(usize, usize)> = (0..columns)
        .map(|c| (0, c))
        .chain((1..rows).map(|r| (r, columns - 1)))
        .chain((0..columns - 1).rev().map(|c| (rows - 1, c)))
        .chain((1..rows - 1).rev().map(|r| (r, 0)))
        .collect();
    // Inside below outside, the way round backwards: then the rim's front looks out.
    let rim = Part::grid(2, edge.len(), true, |row, column| {
        let (r, c) = edge[column];
        if row == 0 { inner(r, c) } else { outer(r, c) }
    });
    let front = Part::grid(rows, columns, false, &outer);
    let back = Part::grid(rows, columns, false, &inner).flipped();
    front.with(back).with(rim)
}
