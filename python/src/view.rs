//! A tile in the hands of a policy in Python: it sees what it has traced, and nothing else.

use std::sync::atomic::{AtomicU64, Ordering};

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

/// Column and row as Python gives them, which may lie anywhere.
type Sample = (i64, i64);

scoped_tls_hkt::scoped_thread_local!(static mut LENT: for<'a> &'a mut Lent);
// Which loan it is: tiles of another frame have the same numbers and places.
scoped_tls_hkt::scoped_thread_local!(static LOAN: u64);

/// How many tiles were lent.
static LOANS: AtomicU64 = AtomicU64::new(0);

/// A tile of the sample grid while a policy decides it. Columns and rows are those of the frame's grid.
///
/// It holds no tile itself: the tile is lent to the thread that calls the policy, as long as the call takes.
#[pyclass(frozen, module = "rayreel._native")]
pub struct TileView {
    loan: u64,
    index: u32,
    rect: Rect,
}

/// Lends a tile to `decide`.
pub fn lend(py: Python<'_>, tile: &mut Lent, decide: impl FnOnce(&Py<TileView>) -> PyResult<()>) -> PyResult<()> {
    let loan = LOANS.fetch_add(1, Ordering::Relaxed);
    let view = Py::new(py, TileView { loan, index: tile.index(), rect: tile.rect() })?;
    LOAN.set(&loan, || LENT.set(tile, || decide(&view)))
}

impl TileView {
    /// The tile, as long as it is lent.
    fn with<T>(&self, what: impl FnOnce(&mut Lent) -> PyResult<T>) -> PyResult<T> {
        const OVER: &str =
            "a view is of use only during the call of begin_tile that it was given to, and in the thread of that call";
        let over = || PyRuntimeError::new_err(OVER);
        if !LOAN.is_set() || LOAN.with(|loan| *loan != self.loan) {
            return Err(over());
        }
        LENT.with(what)
    }

    /// A sample of the tile.
    fn inside(&self, (x, y): Sample) -> PyResult<(u32, u32)> {
        let Rect { x: left, y: top, width, height } = self.rect;
        if let (Ok(column), Ok(row)) = (u32::try_from(x), u32::try_from(y))
            && (left..left + width).contains(&column)
            && (top..top + height).contains(&row)
        {
            return Ok((column, row));
        }
        let (right, bottom) = (left + width - 1, top + height - 1);
        Err(refuse(format!(
            "sample ({x}, {y}) is not in the tile, whose columns are {left} to {right} and rows {top} to {bottom}"
        )))
    }

    /// A sample that is not decided.
    fn open(&self, tile: &Lent, sample: Sample) -> PyResult<(u32, u32)> {
        let (x, y) = self.inside(sample)?;
        match tile.state(x, y) {
            None => Ok((x, y)),
            Some(_) => Err(refuse(format!("sample ({x}, {y}) is decided already; a policy decides each once"))),
        }
    }

    /// The tree of a sample that is known.
    fn tree<'a>(&self, tile: &'a Lent, sample: Sample) -> PyResult<&'a [Node]> {
        let (x, y) = self.inside(sample)?;
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

/// So many values out of a list, a tuple, an array, or whatever else gives them one by one.
fn values<T: for<'a, 'py> FromPyObject<'a, 'py>, const N: usize>(given: &Bound<'_, PyAny>) -> Option<[T; N]> {
    let value = |item: PyResult<Bound<'_, PyAny>>| item.ok()?.extract().ok();
    let values: Option<Vec<T>> = given.try_iter().ok()?.take(N + 1).map(value).collect();
    values?.try_into().ok()
}

/// A sample as Python gives it.
fn sample(given: &Bound<'_, PyAny>) -> PyResult<Sample> {
    match values(given) {
        Some([x, y]) => Ok((x, y)),
        None => Err(refuse(format!("a sample is its column and its row, such as (8, 3), not {given}"))),
    }
}

/// A colour as Python gives it.
fn colour_of(given: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    match values(given) {
        Some([x, y, z]) if [x, y, z].iter().all(|part: &f32| part.is_finite() && *part >= 0.0) => Ok(Vec3 { x, y, z }),
        _ => Err(refuse(format!("a colour is three finite numbers of 0 or more, not {given}"))),
    }
}

/// A round as Python gives it.
fn round_of(round: i64) -> PyResult<u8> {
    u8::try_from(round).map_err(|_| refuse(format!("a round is from 0 to 255, not {round}")))
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
    fn trace(&self, x: i64, y: i64, round: i64, reference: bool) -> PyResult<()> {
        let round = round_of(round)?;
        self.with(|tile| {
            let (x, y) = self.open(tile, (x, y))?;
            tile.trace(x, y, state(reference), round);
            Ok(())
        })
    }

    /// Traces the samples where `mask`, of the tile's rows and columns, is true.
    #[pyo3(signature = (mask, round=0, reference=true))]
    fn trace_mask(&self, mask: &Bound<'_, PyAny>, round: i64, reference: bool) -> PyResult<()> {
        let (round, (width, height)) = (round_of(round)?, self.size());
        let mask: PyReadonlyArray2<'_, bool> = mask.extract().map_err(|_| {
            refuse(format!(
                "the mask is an array of bool of two dimensions, of shape ({height}, {width}) for this tile"
            ))
        })?;
        if mask.shape() != [height as usize, width as usize] {
            return Err(refuse(format!("the mask has shape {:?}; the tile has ({height}, {width})", mask.shape())));
        }
        self.with(|tile| {
            let mask = mask.as_array();
            let wanted = tile.samples().zip(mask.iter()).filter(|(_, wanted)| **wanted);
            let wanted: Vec<(u32, u32)> = wanted.map(|(at, _)| at).collect();
            wanted.iter().try_for_each(|&(x, y)| self.open(tile, (x.into(), y.into())).map(drop))?;
            wanted.iter().for_each(|&(x, y)| tile.trace(x, y, state(reference), round));
            Ok(())
        })
    }

    /// Gives a sample what lies `share` of the way from sample `near` to sample `far`.
    #[pyo3(signature = (x, y, near, far, share=0.5, round=1))]
    fn interpolate(
        &self,
        x: i64,
        y: i64,
        near: &Bound<'_, PyAny>,
        far: &Bound<'_, PyAny>,
        share: f32,
        round: i64,
    ) -> PyResult<()> {
        if !(0.0..=1.0).contains(&share) {
            return Err(refuse(format!("a share is from 0 to 1, not {share}")));
        }
        let (round, near, far) = (round_of(round)?, sample(near)?, sample(far)?);
        self.with(|tile| {
            let (x, y) = self.open(tile, (x, y))?;
            let (near, far) = (self.tree(tile, near)?, self.tree(tile, far)?);
            let tree = if share <= 0.5 { between(near, far, share) } else { between(far, near, 1.0 - share) };
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample what sample `source` has.
    #[pyo3(signature = (x, y, source, round=1))]
    fn copy(&self, x: i64, y: i64, source: &Bound<'_, PyAny>, round: i64) -> PyResult<()> {
        let (round, source) = (round_of(round)?, sample(source)?);
        self.with(|tile| {
            let (x, y) = self.open(tile, (x, y))?;
            let tree = self.tree(tile, source)?.to_vec();
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample a colour, linear RGB of three finite numbers of 0 or more, and no surface.
    #[pyo3(signature = (x, y, colour, round=1))]
    fn paint(&self, x: i64, y: i64, colour: &Bound<'_, PyAny>, round: i64) -> PyResult<()> {
        let (round, colour) = (round_of(round)?, colour_of(colour)?);
        let none = (None, None);
        let (surface, (reflect, refract)) = (None, none);
        let node = Node { surface, local: colour, colour, reflect, refract, hit_rays: 0, rays: 0, len: 1, age: 0 };
        self.with(|tile| {
            let (x, y) = self.open(tile, (x, y))?;
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

    /// Where the primary rays of the known samples met a surface. `shadows` has two bits a light, as recorded: it is 0 where nothing is
    /// known too.
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
