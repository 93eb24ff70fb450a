//! A tile in the hands of a policy in Python: it sees what it has traced, and nothing else.

use numpy::{PyArray1, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayreel_formats::math::Vec3;
use rayreel_formats::scene::Rect;
use rayreel_replay::policy::tree::{Node, SurfacePoint};
use rayreel_replay::policy::{SampleState, TileView as Lent, between};

use crate::columns::{picture, plane};
use crate::error::refuse;

scoped_tls_hkt::scoped_thread_local!(static mut LENT: for<'a> &'a mut Lent);

/// A tile of the sample grid while a policy decides it. Columns and rows are those of the frame's grid.
///
/// It holds no tile itself: the tile is lent to the thread that calls the policy, as long as the call takes.
#[pyclass(frozen, module = "rayreel._native")]
pub struct TileView {
    index: u32,
    rect: Rect,
}

/// Lends a tile to `decide`.
pub fn lend(py: Python<'_>, tile: &mut Lent, decide: impl FnOnce(&Py<TileView>) -> PyResult<()>) -> PyResult<()> {
    let view = Py::new(py, TileView { index: tile.index(), rect: tile.rect() })?;
    LENT.set(tile, || decide(&view))
}

impl TileView {
    /// The tile, as long as it is lent.
    fn with<T>(&self, what: impl FnOnce(&mut Lent) -> PyResult<T>) -> PyResult<T> {
        let over =
            || PyRuntimeError::new_err("a view is of use only during the call of begin_tile that it was given to");
        if !LENT.is_set() {
            return Err(over());
        }
        LENT.with(|tile| if (tile.index(), tile.rect()) == (self.index, self.rect) { what(tile) } else { Err(over()) })
    }

    fn inside(&self, (x, y): (u32, u32)) -> PyResult<()> {
        let Rect { x: left, y: top, width, height } = self.rect;
        if (left..left + width).contains(&x) && (top..top + height).contains(&y) {
            return Ok(());
        }
        let (right, bottom) = (left + width - 1, top + height - 1);
        Err(refuse(format!(
            "sample ({x}, {y}) is not in the tile, whose columns are {left} to {right} and rows {top} to {bottom}"
        )))
    }

    /// A sample that is not decided.
    fn open(&self, tile: &Lent, (x, y): (u32, u32)) -> PyResult<()> {
        self.inside((x, y))?;
        match tile.state(x, y) {
            None => Ok(()),
            Some(_) => Err(refuse(format!("sample ({x}, {y}) is decided already; a policy decides each once"))),
        }
    }

    /// The tree of a sample that is known.
    fn tree<'a>(&self, tile: &'a Lent, (x, y): (u32, u32)) -> PyResult<&'a [Node]> {
        self.inside((x, y))?;
        match tile.state(x, y) {
            Some(_) => Ok(tile.tree(x, y)),
            None => Err(refuse(format!("sample ({x}, {y}) is not known yet; trace it first"))),
        }
    }

    /// A value of each sample, row by row; `none` where nothing is known, or `of` has none.
    fn each<T: Copy>(&self, none: T, of: impl Fn(&Node) -> Option<T>) -> PyResult<Vec<T>> {
        self.with(|tile| {
            let known = |(x, y)| tile.state(x, y).map(|_| &tile.tree(x, y)[0]);
            Ok(tile.samples().map(|at| known(at).and_then(&of).unwrap_or(none)).collect())
        })
    }

    fn size(&self) -> (u32, u32) {
        (self.rect.width, self.rect.height)
    }

    fn vectors<'py>(&self, py: Python<'py>, of: impl Fn(&Node) -> Option<Vec3>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.each([f32::NAN; 3], |node| of(node).map(|v| [v.x, v.y, v.z]))?;
        picture(py, self.size(), values.into_iter().flatten().collect())
    }
}

fn surface<T>(of: impl Fn(&SurfacePoint) -> T) -> impl Fn(&Node) -> Option<T> {
    move |node| node.surface.as_ref().map(&of)
}

fn state(reference: bool) -> SampleState {
    if reference { SampleState::Reference } else { SampleState::Traced }
}

#[pymethods]
impl TileView {
    /// Number of the tile in the frame.
    #[getter]
    fn index(&self) -> u32 {
        self.index
    }

    /// First column.
    #[getter]
    fn x(&self) -> u32 {
        self.rect.x
    }

    /// First row.
    #[getter]
    fn y(&self) -> u32 {
        self.rect.y
    }

    /// Columns.
    #[getter]
    fn width(&self) -> u32 {
        self.rect.width
    }

    /// Rows.
    #[getter]
    fn height(&self) -> u32 {
        self.rect.height
    }

    /// Traces a sample with all its rays.
    #[pyo3(signature = (x, y, round=0, reference=true))]
    fn trace(&self, x: u32, y: u32, round: u8, reference: bool) -> PyResult<()> {
        self.with(|tile| {
            self.open(tile, (x, y))?;
            tile.trace(x, y, state(reference), round);
            Ok(())
        })
    }

    /// Traces the samples where `mask`, of the tile's rows and columns, is true.
    #[pyo3(signature = (mask, round=0, reference=true))]
    fn trace_mask(&self, mask: PyReadonlyArray2<'_, bool>, round: u8, reference: bool) -> PyResult<()> {
        let (width, height) = self.size();
        if mask.shape() != [height as usize, width as usize] {
            return Err(refuse(format!("the mask has shape {:?}; the tile has ({height}, {width})", mask.shape())));
        }
        self.with(|tile| {
            let mask = mask.as_array();
            let wanted = tile.samples().zip(mask.iter()).filter(|(_, wanted)| **wanted);
            let wanted: Vec<(u32, u32)> = wanted.map(|(at, _)| at).collect();
            wanted.iter().try_for_each(|&at| self.open(tile, at))?;
            wanted.iter().for_each(|&(x, y)| tile.trace(x, y, state(reference), round));
            Ok(())
        })
    }

    /// Gives a sample what lies `share` of the way from sample `near` to sample `far`.
    #[pyo3(signature = (x, y, near, far, share=0.5, round=1))]
    fn interpolate(&self, x: u32, y: u32, near: (u32, u32), far: (u32, u32), share: f32, round: u8) -> PyResult<()> {
        if !(0.0..=1.0).contains(&share) {
            return Err(refuse(format!("a share is from 0 to 1, not {share}")));
        }
        self.with(|tile| {
            self.open(tile, (x, y))?;
            let (near, far) = (self.tree(tile, near)?, self.tree(tile, far)?);
            let tree = if share <= 0.5 { between(near, far, share) } else { between(far, near, 1.0 - share) };
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample what sample `source` has.
    #[pyo3(signature = (x, y, source, round=1))]
    fn copy(&self, x: u32, y: u32, source: (u32, u32), round: u8) -> PyResult<()> {
        self.with(|tile| {
            self.open(tile, (x, y))?;
            let tree = self.tree(tile, source)?.to_vec();
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample a colour, linear RGB, and no surface.
    #[pyo3(signature = (x, y, colour, round=1))]
    fn paint(&self, x: u32, y: u32, colour: [f32; 3], round: u8) -> PyResult<()> {
        let [r, g, b] = colour;
        let colour = Vec3 { x: r, y: g, z: b };
        let none = (None, None);
        let (surface, (reflect, refract)) = (None, none);
        let node = Node { surface, local: colour, colour, reflect, refract, hit_rays: 0, rays: 0, len: 1, age: 0 };
        self.with(|tile| {
            self.open(tile, (x, y))?;
            tile.interpolate(x, y, &[node], round);
            Ok(())
        })
    }

    /// Which samples are known.
    #[getter]
    fn known<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plane(py, self.size(), self.each(false, |_| Some(true))?)
    }

    /// Colours of the samples that are known; others are not numbers.
    #[getter]
    fn colours<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.vectors(py, |node| Some(node.colour))
    }

    /// Where the primary rays of the known samples met a surface.
    #[getter]
    fn surfaces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (dict, size) = (PyDict::new(py), self.size());
        dict.set_item("object", plane(py, size, self.each(-1, surface(|s| s.object as i32))?)?)?;
        dict.set_item("depth", plane(py, size, self.each(f32::NAN, surface(|s| s.t))?)?)?;
        dict.set_item("shadows", plane(py, size, self.each(0, surface(|s| s.shadows.0))?)?)?;
        dict.set_item("normal", self.vectors(py, surface(|s| s.normal))?)?;
        dict.set_item("position", self.vectors(py, surface(|s| s.position))?)?;
        Ok(dict)
    }

    /// Columns and rows of all samples, row by row.
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Rect { x, y, width, height } = self.rect;
        let all: Vec<u32> = (y..y + height).flat_map(|v| (x..x + width).flat_map(move |u| [u, v])).collect();
        Ok(PyArray1::from_vec(py, all).reshape([self.rect.len(), 2])?.into_any())
    }

    fn __repr__(&self) -> String {
        let Rect { x, y, width, height } = self.rect;
        format!("<rayreel.TileView {}: {width} x {height} samples from ({x}, {y})>", self.index)
    }
}
