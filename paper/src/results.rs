//! What the points of the plan have come to.

use rayreel_study::point::details::{Details, FrameDetails, TileFigures};
use rayreel_study::point::key::Point;
use rayreel_study::point::row::Row;
use rayreel_study::point::task::Missing;
use rayreel_study::point::wanted::Figures;
use serde_json::{Map, Value};

use crate::frame::FrameView;

/// The results of one point, as far as they are there.
#[derive(Clone, Debug, Default)]
pub struct PointResult {
    /// Figures of its row; empty without one.
    pub row: Option<Map<String, Value>>,
    /// Its details.
    pub details: Option<Details>,
}

impl PointResult {
    /// Takes a row, if it says all that is needed of a point and not that it cannot be computed.
    pub fn take_row(&mut self, point: &Point, row: Row) -> bool {
        let good = row.error.is_none() && FrameView::new(&row.figures, point).is_complete();
        self.row = good.then_some(row.figures);
        good
    }

    /// Which results of the point are missing.
    pub fn missing(&self, point: &Point) -> Missing {
        let wanted = Missing::all(point);
        Missing { row: wanted.row && self.row.is_none(), details: wanted.details && self.details.is_none() }
    }
}

/// The results of all points of a plan, in its order.
pub struct Results {
    points: Vec<(Point, Map<String, Value>, Details)>,
}

/// A frame of a point whose frames were wanted one by one.
#[derive(Clone, Copy)]
pub struct FrameOf<'a> {
    /// Its number.
    pub frame: u32,
    /// Its figures.
    pub view: FrameView<'a>,
    /// Sum of the squared errors, and number of values.
    pub error: Option<(u64, u64)>,
    /// Squared change of the error since the frame before, and number of values.
    pub flicker: Option<(u64, u64)>,
}

impl Results {
    /// The results of points of which nothing is missing.
    pub fn new(points: impl IntoIterator<Item = (Point, PointResult)>) -> Option<Self> {
        let whole = |(point, result): (Point, PointResult)| {
            let whole = !result.missing(&point).any();
            whole.then(|| (point, result.row.unwrap_or_default(), result.details.unwrap_or_default()))
        };
        Some(Self { points: points.into_iter().map(whole).collect::<Option<_>>()? })
    }

    /// The row of point number `point`, which has one frame.
    pub fn frame(&self, point: usize) -> FrameView<'_> {
        let (point, row, _) = &self.points[point];
        FrameView::new(row, point)
    }

    /// The frames of a point, one by one.
    pub fn frames(&self, point: usize) -> impl Iterator<Item = FrameOf<'_>> {
        let (point, _, details) = &self.points[point];
        details.frames.iter().filter_map(move |frame| {
            let figures = frame.figures.as_ref()?;
            let view = FrameView::one_of(&figures.row, point, is_simulated(point, frame));
            Some(FrameOf { frame: frame.frame, view, error: figures.error, flicker: figures.flicker })
        })
    }

    /// The tiles of a point of one frame.
    pub fn tiles(&self, point: usize) -> &[TileFigures] {
        self.points[point].2.frames.first().map_or(&[], |frame| &frame.tiles)
    }
}

/// Whether a frame was simulated, if the point has a machine.
fn is_simulated(point: &Point, frame: &FrameDetails) -> bool {
    match &point.wanted.figures {
        Figures::Row => true,
        Figures::Frames { simulated, .. } => simulated.contains(&frame.frame),
    }
}
