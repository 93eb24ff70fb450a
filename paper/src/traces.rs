//! The traces in the cache folder: taken if they are whole and of the very capture that is wanted, made otherwise.

use std::path::Path;

use rayon::prelude::*;
use rayreel_formats::container::{ChunkId, Writer};
use rayreel_formats::scene::Meta;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_formats::{Error, Limits};
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

/// Whether there is a partial capture to go on with; one of other settings, or that cannot be gone on with, is dropped, since the
/// cache is ours.
fn is_resumable(path: &Path, wanted: &Meta) -> Result<bool> {
    let resumed = match Writer::resume(path, &Limits::default()) {
        Ok(None) => return Ok(false),
        Ok(Some(resumed)) => resumed,
        // Dropping it would take it from who writes it, or is refused as well.
        Err(error @ (Error::Occupied { .. } | Error::Io { .. })) => return Err(error.into()),
        Err(_) => {
            Writer::discard(path)?;
            return Ok(false);
        }
    };
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

#[cfg(test)]
mod tests {
    use std::fs;

    use rayreel_tracer::{SampleGrid, TOOL, TraceSettings};

    use super::*;

    fn meta() -> Meta {
        let grid = SampleGrid { width: 16, height: 8, samples: 1, tile: 32, first_frame: 0, frames: 1 };
        grid.meta(&rayreel_scenes::load("cornell").unwrap(), TraceSettings::default(), TOOL)
    }

    /// The experiment never began again: every run was refused because of it.
    #[test]
    fn a_partial_capture_that_is_none_is_dropped() {
        let (folder, meta) = (tempfile::tempdir().unwrap(), meta());
        let [path, partial] = ["a.rtrace", "a.rtrace.partial"].map(|name| folder.path().join(name));
        drop(Writer::create(&path).unwrap());
        let whole = fs::read(&partial).unwrap();
        let changed = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x40;
            bytes
        };
        // Damaged or newer at any byte of its header, and no trace at all.
        let spoilt = (0..whole.len()).map(changed).chain([b"a file that is no trace, longer than a header".repeat(9)]);
        for bytes in spoilt {
            fs::write(&partial, bytes).unwrap();
            assert!(Writer::resume(&path, &Limits::default()).is_err());
            assert!(!is_resumable(&path, &meta).unwrap() && !partial.exists());
        }
        assert!(!is_resumable(&path, &meta).unwrap(), "there is none");
    }

    #[test]
    fn a_partial_capture_that_another_writes_is_left_alone() {
        let (folder, meta) = (tempfile::tempdir().unwrap(), meta());
        let [path, partial] = ["a.rtrace", "a.rtrace.partial"].map(|name| folder.path().join(name));
        let writer = Writer::create(&path).unwrap();
        let refused = is_resumable(&path, &meta).unwrap_err();
        assert!(matches!(refused, PaperError::Trace(Error::Occupied { .. })) && partial.exists(), "{refused}");
        drop(writer);
        assert!(!is_resumable(&path, &meta).unwrap() && !partial.exists(), "it is of no capture");
    }
}
