//! What a row does not hold: figures of single frames and tiles, and pictures.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::point::key::Point;
use crate::point::row::Row;
use crate::report::{Origin, Report, TileReport};
use rayreel_formats::scene::Meta;
use rayreel_replay::counts::FrameStats;
use rayreel_replay::image::psnr::SquaredError;
use rayreel_replay::simulate::MachineRun;

/// Results say nowhere what a trace was called: it is in no key.
pub(crate) fn no_origin() -> Origin {
    Origin::default()
}

/// The second kind of result of a point: a pure function of its key, as a row is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// The frames of which something was wanted, in order.
    pub frames: Vec<FrameDetails>,
    /// PNG files, in the order in which they were wanted; empty where a replay has no such picture.
    pub pictures: Vec<Vec<u8>>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameDetails {
    /// Position in the camera path, from 0.
    pub frame: u32,
    /// Its figures, if those of frames were wanted.
    pub figures: Option<FrameFigures>,
    /// Its tiles, if they were wanted.
    pub tiles: Vec<TileFigures>,
}

/// The figures of one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameFigures {
    /// Figures and counters, as a row of this frame alone has them.
    pub row: Map<String, Value>,
    /// Sum of the squared errors of all 8-bit values, and their number; if it was compared.
    pub error: Option<(u64, u64)>,
    /// Squared change of the error since the frame before, and the number of values; nothing for the first.
    pub flicker: Option<(u64, u64)>,
}

/// One tile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TileFigures {
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays of the traced samples.
    pub rays_traced: u64,
    /// Rays of samples of other tiles, traced again.
    pub rays_apron: u64,
    /// Samples traced.
    pub samples_traced: u64,
    /// Samples interpolated.
    pub samples_interpolated: u64,
    /// Interpolated per I-sample.
    pub similarity_ratio: Option<f64>,
    /// PSNR, dB; null if nothing differs.
    pub psnr_db: Option<f64>,
}

impl FrameFigures {
    /// Those of a replayed frame, on the machine if it was simulated.
    pub(crate) fn new(point: &Point, meta: &Meta, stats: &FrameStats, run: Option<&MachineRun>) -> Self {
        let pair = |error: SquaredError| (error.sum, error.values);
        let quality = stats.quality.as_ref();
        let mut report = Report::new(&no_origin(), &point.policy, meta, std::slice::from_ref(stats));
        if let (Some(machine), Some(run)) = (&point.machine, run) {
            report = report.with_machine(machine, std::slice::from_ref(run));
        }
        Self {
            row: Row::new(String::new(), &report.without_tiles()).0.figures,
            error: quality.map(|q| (q.squared_error, q.values)),
            flicker: quality.and_then(|q| q.flicker).map(pair),
        }
    }
}

impl From<&TileReport> for TileFigures {
    fn from(tile: &TileReport) -> Self {
        Self {
            rays_full: tile.rays_full,
            rays_traced: tile.rays_traced,
            rays_apron: tile.rays_apron,
            samples_traced: tile.samples_traced,
            samples_interpolated: tile.samples_interpolated,
            similarity_ratio: tile.similarity_ratio,
            psnr_db: tile.psnr_db,
        }
    }
}

impl TileFigures {
    /// The tiles of a replayed frame.
    pub(crate) fn of_frame(point: &Point, meta: &Meta, stats: &FrameStats) -> Vec<Self> {
        let report = Report::new(&no_origin(), &point.policy, meta, std::slice::from_ref(stats));
        report.frames.iter().flat_map(|frame| &frame.tiles).map(Self::from).collect()
    }
}

/// The line of JSON.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    frames: Vec<FrameDetails>,
    /// Length of each picture, bytes.
    pictures: Vec<usize>,
}

impl Details {
    /// The bytes of a file: the BLAKE3 hash of all that follows its first line, in hexadecimal; then a line of JSON, then the
    /// pictures, one after the other.
    ///
    /// # Errors
    /// Never for details of a replay: their numbers are finite.
    pub(crate) fn encode(&self) -> crate::Result<Vec<u8>> {
        let head = Head { frames: self.frames.clone(), pictures: self.pictures.iter().map(Vec::len).collect() };
        let mut body = serde_json::to_vec(&head).map_err(crate::StudyError::json)?;
        body.push(b'\n');
        self.pictures.iter().for_each(|picture| body.extend_from_slice(picture));
        let mut bytes = format!("{}\n", blake3::hash(&body)).into_bytes();
        bytes.append(&mut body);
        Ok(bytes)
    }

    /// What [`Self::encode`] wrote; nothing if any of it was changed.
    pub(crate) fn decode(bytes: &[u8]) -> Option<Self> {
        let (hash, body) = line(bytes)?;
        if hash != blake3::hash(body).to_hex().as_bytes() {
            return None;
        }
        let (head, mut rest) = line(body)?;
        let head: Head = serde_json::from_slice(head).ok()?;
        let mut pictures = Vec::new();
        for len in head.pictures {
            let (picture, after) = rest.split_at_checked(len)?;
            pictures.push(picture.to_vec());
            rest = after;
        }
        rest.is_empty().then_some(Self { frames: head.frames, pictures })
    }
}

/// The first line without its end, and the rest.
fn line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| *b == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}
