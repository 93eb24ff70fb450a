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

use crate::arguments::{Given, Whole, or_none};
use crate::columns::{picture, plane};
use crate::error::refuse;

/// Column and row as Python gives them, which may lie anywhere.
type Sample = (i64, i64);

/// The largest part of a colour: pixels are sums, and these stay finite.
const BRIGHTEST: f32 = 1e30;

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

/// So many values out of a list, a tuple, an array, or whatever else gives them one by one; nothing if it does not.
fn values<T: for<'a, 'py> FromPyObject<'a, 'py>, const N: usize>(given: &Bound<'_, PyAny>) -> PyResult<Option<[T; N]>> {
    let all = || given.try_iter()?.take(N + 1).map(|item| item?.extract().map_err(Into::into)).collect();
    let values: Option<Vec<T>> = or_none(all())?;
    Ok(values.and_then(|values| values.try_into().ok()))
}

/// A sample as Python gives it.
fn sample(given: &Bound<'_, PyAny>) -> PyResult<Sample> {
    match values(given)? {
        Some([Whole(x), Whole(y)]) => Ok((x, y)),
        None => Err(refuse(format!("a sample is its column and its row, such as (8, 3), not {given}"))),
    }
}

/// The same in two arguments.
fn sample_at(x: Given<Whole>, y: Given<Whole>) -> PyResult<Sample> {
    const WHAT: &str = "a whole number in the tile";
    Ok((x.value("x", WHAT)?.0, y.value("y", WHAT)?.0))
}

/// A colour as Python gives it.
fn colour_of(given: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    match values(given)? {
        Some([x, y, z]) if [x, y, z].iter().all(|part| (0.0..=BRIGHTEST).contains(part)) => Ok(Vec3 { x, y, z }),
        _ => Err(refuse(format!("a colour is three numbers from 0 to {BRIGHTEST:e}, not {given}"))),
    }
}

/// A round as Python gives it.
fn round_of(round: Given<Whole>) -> PyResult<u8> {
    const WHAT: &str = "a whole number from 0 to 255";
    let Whole(round) = round.value("round", WHAT)?;
    u8::try_from(round).map_err(|_| refuse(format!("round is {WHAT}, not {round}")))
}

/// How far from one sample to another, as Python gives it.
fn share_of(share: Given<f32>) -> PyResult<f32> {
    const WHAT: &str = "a number from 0 to 1";
    let share = share.value("share", WHAT)?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err(refuse(format!("share is {WHAT}, not {share}"))) }
}

/// What becomes of samples that are traced.
fn traced(reference: Given<bool>) -> PyResult<SampleState> {
    let reference = reference.value("reference", "True or False")?;
    Ok(if reference { SampleState::Reference } else { SampleState::Traced })
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
    #[pyo3(
        signature = (x, y, round=Given::default(Whole(0)), reference=Given::default(true)),
        text_signature = "($self, x, y, round=0, reference=True)"
    )]
    fn trace(&self, x: Given<Whole>, y: Given<Whole>, round: Given<Whole>, reference: Given<bool>) -> PyResult<()> {
        let (at, round, state) = (sample_at(x, y)?, round_of(round)?, traced(reference)?);
        self.with(|tile| {
            let (x, y) = self.open(tile, at)?;
            tile.trace(x, y, state, round);
            Ok(())
        })
    }

    /// Traces the samples where `mask`, of the tile's rows and columns, is true.
    #[pyo3(
        signature = (mask, round=Given::default(Whole(0)), reference=Given::default(true)),
        text_signature = "($self, mask, round=0, reference=True)"
    )]
    fn trace_mask(&self, mask: &Bound<'_, PyAny>, round: Given<Whole>, reference: Given<bool>) -> PyResult<()> {
        let (round, state, (width, height)) = (round_of(round)?, traced(reference)?, self.size());
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
            wanted.iter().for_each(|&(x, y)| tile.trace(x, y, state, round));
            Ok(())
        })
    }

    /// Gives a sample what lies `share` of the way from sample `near` to sample `far`.
    #[pyo3(
        signature = (x, y, near, far, share=Given::default(0.5), round=Given::default(Whole(1))),
        text_signature = "($self, x, y, near, far, share=0.5, round=1)"
    )]
    fn interpolate(
        &self,
        x: Given<Whole>,
        y: Given<Whole>,
        near: &Bound<'_, PyAny>,
        far: &Bound<'_, PyAny>,
        share: Given<f32>,
        round: Given<Whole>,
    ) -> PyResult<()> {
        let (at, share, round) = (sample_at(x, y)?, share_of(share)?, round_of(round)?);
        let (near, far) = (sample(near)?, sample(far)?);
        self.with(|tile| {
            let (x, y) = self.open(tile, at)?;
            let (near, far) = (self.tree(tile, near)?, self.tree(tile, far)?);
            let tree = if share <= 0.5 { between(near, far, share) } else { between(far, near, 1.0 - share) };
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample what sample `source` has.
    #[pyo3(
        signature = (x, y, source, round=Given::default(Whole(1))),
        text_signature = "($self, x, y, source, round=1)"
    )]
    fn copy(&self, x: Given<Whole>, y: Given<Whole>, source: &Bound<'_, PyAny>, round: Given<Whole>) -> PyResult<()> {
        let (at, round, source) = (sample_at(x, y)?, round_of(round)?, sample(source)?);
        self.with(|tile| {
            let (x, y) = self.open(tile, at)?;
            let tree = self.tree(tile, source)?.to_vec();
            tile.interpolate(x, y, &tree, round);
            Ok(())
        })
    }

    /// Gives a sample a colour, linear RGB of three numbers from 0 to 1e30, and no surface.
    #[pyo3(
        signature = (x, y, colour, round=Given::default(Whole(1))),
        text_signature = "($self, x, y, colour, round=1)"
    )]
    fn paint(&self, x: Given<Whole>, y: Given<Whole>, colour: &Bound<'_, PyAny>, round: Given<Whole>) -> PyResult<()> {
        let (at, round, colour) = (sample_at(x, y)?, round_of(round)?, colour_of(colour)?);
        let none = (None, None);
        let (surface, (reflect, refract)) = (None, none);
        let node = Node { surface, local: colour, colour, reflect, refract, hit_rays: 0, rays: 0, len: 1, age: 0 };
        self.with(|tile| {
            let (x, y) = self.open(tile, at)?;
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
