//! The traces in the cache folder: taken if they are whole and of the very capture that is wanted, made otherwise.

use std::path::Path;

use rayon::prelude::*;
use rayreel_formats::Limits;
use rayreel_formats::container::{ChunkId, Writer};
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_scenes::Scene;
use rayreel_tracer::accel::Built;
use rayreel_tracer::capture::{self, CaptureOutcome, CaptureOutput};

use crate::error::{PaperError, Result};

/// zstd level of the BVH: the file is ours and may be larger, its making should not take longer than tracing.
const LEVEL: i32 = 3;

/// The trace at `path`, if it is whole and of this very capture; every chunk of it is read and its checksum compared.
pub fn cached(path: &Path, wanted: &Meta) -> Option<Trace> {
    let trace = Trace::open(path, Limits::default()).ok()?;
    let whole = || trace.reader().chunks().par_iter().all(|record| trace.reader().read(record).is_ok());
    (trace.meta() == wanted && trace.missing_tiles().is_empty() && whole()).then_some(trace)
}

/// Captures into a file and opens it. `tell` is told how many tiles are done, and how many there are.
///
/// # Errors
/// When the frames are outside the camera path, or the file cannot be written; an interruption.
pub fn make(
    scene: &Scene,
    built: &Built,
    (path, meta): (&Path, &Meta),
    is_stopped: &dyn Fn() -> bool,
    mut tell: impl FnMut(u64, u64),
) -> Result<Trace> {
    let resume = is_resumable(path, meta)?;
    let output = CaptureOutput { resume, ..CaptureOutput::new(path.into(), Codec::Context, LEVEL) };
    let outcome = capture::capture(scene, built, meta, &output, |now| {
        tell(now.tiles, now.tiles_total);
        !is_stopped()
    })?;
    match outcome {
        CaptureOutcome::Finished(_) if !is_stopped() => Ok(Trace::open(path, Limits::default())?),
        _ => Err(PaperError::interrupted()),
    }
}

/// Whether there is a partial capture to go on with; one of other settings is dropped, since the cache is ours.
fn is_resumable(path: &Path, wanted: &Meta) -> Result<bool> {
    let Some(resumed) = Writer::resume(path, &Limits::default())? else { return Ok(false) };
    let record = resumed.chunks().iter().find(|c| c.id == ChunkId::META).copied();
    let same = record
        .and_then(|r| resumed.read(&r).ok())
        .and_then(|bytes| Meta::from_payload(&bytes, &Limits::default()).ok());
    drop(resumed);
    if same.as_ref() == Some(wanted) {
        return Ok(true);
    }
    Writer::discard(path)?;
    Ok(false)
}
