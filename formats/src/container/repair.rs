//! Makes a valid file of what is whole in a damaged or unfinished one.

use std::collections::{BTreeSet, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;

use super::chunk_file::ChunkFile;
use super::chunk_header::{CHUNK_HEADER_LEN, ChunkHeader, ChunkRecord};
use super::index::Index;
use super::reader::read_file_header;
use super::resume::header_is_torn;
use super::scan::{DamagedRange, Scan, scan_file};
use super::walk::STEP;
use super::writer::{Writer, behind, open_locked, with_suffix};
use crate::error::{Error, Occupant, Result};
use crate::id::{ChunkId, ChunkKind, FormatVersion, NONE};
use crate::limits::Limits;

/// What a repair did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RepairReport {
    /// Length of the new file in bytes.
    pub file_len: u64,
    /// Chunks in the new file, without the index.
    pub kept: u64,
    /// Whole chunks left out because an earlier chunk has the same id.
    pub duplicates: u64,
    /// What could not be used of the old file.
    pub damaged: Vec<DamagedRange>,
    /// Chunks known to have been in the old file, from its index or from headers in damaged ranges, that are not in the
    /// new one; sorted. If the index was lost, there may be others.
    pub lost: Vec<ChunkId>,
    /// Chunks that nothing can be read without, and that the new file lacks: `META` and `BVH `. Whatever else it holds, it is no
    /// trace unless this is empty.
    pub indispensable: Vec<ChunkId>,
    /// Whether the old file had a whole index, so that `lost` is complete.
    pub had_index: bool,
    /// Version of the new file: that of the old one, or the current one if the old header is damaged.
    pub version: FormatVersion,
}

/// Copies every whole chunk of `input` to the new file `output`, in canonical order: `META`, `BVH `, then frame by
/// frame its `FRAM` and its tiles. Chunks are copied as they are, those of unknown kinds too. `input` is only read.
///
/// Works on finished files, `NAME.partial`, truncated and damaged files. Until it is done, the output is
/// `OUTPUT.repairing`, which is removed if the repair fails. What a killed repair left there is written over; any other file of that
/// name is refused.
///
/// # Errors
/// [`Error::Usage`] if input and output are the same file; [`Error::Occupied`] if there is an output, or one in the making; the errors of
/// [`scan`](super::scan()); [`Error::Damaged`] if no chunk is whole.
pub fn repair(input: &Path, output: &Path, limits: &Limits) -> Result<RepairReport> {
    refuse_existing(input, output)?;
    let file = ChunkFile::open(input, limits.clone())?;
    let scan = scan_file(&file)?;
    let (kept, duplicates) = canonical(&scan.chunks);
    if kept.is_empty() {
        return Err(Error::corrupt(file.place(0), "no chunk of this file is whole"));
    }
    let expected = indexed(&file, &scan);
    let lost = lost(&kept, &scan, expected.as_deref());
    let absent = |id: &ChunkId| !kept.iter().any(|record| record.id == *id);
    let indispensable = [ChunkId::META, ChunkId::BVH].into_iter().filter(absent).collect();
    let version = scan.version.unwrap_or(FormatVersion::CURRENT);
    let output = &behind(output)?;
    let temporary = with_suffix(output, ".repairing")?;
    let place = |path: &Path| fs::canonicalize(path).ok();
    if place(&temporary).is_some_and(|unfinished| Some(unfinished) == place(input)) {
        let what = format!("{} is where the repair would write until it is done; name another output", input.display());
        return Err(Error::usage(what));
    }
    let remove = |_: &Error| _ = fs::remove_file(&temporary);
    let locked = open_locked(&temporary, || open_temporary(&temporary))?;
    // Another repair may have finished since this one began.
    refuse_existing(input, output).inspect_err(remove)?;
    locked.set_len(0).map_err(|error| Error::io(&temporary, "truncate", error))?;
    // Its unfinished file is not `OUTPUT.partial`, since that may be the input.
    let mut writer = Writer::start(locked, temporary.clone(), output.clone(), version).inspect_err(remove)?;
    kept.iter().try_for_each(|record| writer.copy(&file, record)).inspect_err(remove)?;
    let finished = writer.finish().inspect_err(remove)?;
    Ok(RepairReport {
        file_len: finished.len,
        kept: finished.chunks,
        duplicates,
        damaged: scan.damaged,
        lost,
        indispensable,
        had_index: expected.is_some(),
        version,
    })
}

fn refuse_existing(input: &Path, output: &Path) -> Result<()> {
    let Ok(existing) = fs::canonicalize(output) else {
        return Ok(());
    };
    if fs::canonicalize(input).is_ok_and(|input| input == existing) {
        return Err(Error::usage("a file cannot be repaired in place; name another output"));
    }
    Err(Error::occupied(output, Occupant::File { hint: "name another output, or delete this file" }))
}

/// The first chunk of every id in canonical order, and the number of chunks left out.
fn canonical(chunks: &[ChunkRecord]) -> (Vec<ChunkRecord>, u64) {
    let mut seen = HashSet::new();
    let mut kept = chunks.to_vec();
    kept.retain(|record| seen.insert(record.id) || !record.id.kind.is_known());
    let duplicates = (chunks.len() - kept.len()) as u64;
    kept.sort_by_key(canonical_key);
    (kept, duplicates)
}

/// Sorts chunks of the whole file first, then by frame; within those by kind, unknown kinds last and in file order.
fn canonical_key(record: &ChunkRecord) -> (u64, u8, u32, u64) {
    let id = record.id;
    let group = if id.frame == NONE { 0 } else { u64::from(id.frame) + 1 };
    let (rank, tile) = match id.kind {
        ChunkKind::META => (0, 0),
        ChunkKind::BVH => (1, 0),
        ChunkKind::FRAM => (2, 0),
        ChunkKind::TILE => (3, id.tile),
        _ => (4, 0),
    };
    (group, rank, tile, record.offset)
}

/// The chunks that the old index lists, if it can be read. Nothing is copied by it, so a wrong one does no harm.
fn indexed(file: &ChunkFile, scan: &Scan) -> Option<Vec<ChunkId>> {
    let room = file.len() / CHUNK_HEADER_LEN;
    let raw = file.read(&scan.index?, Index::raw_len_max(room)).ok()?;
    Some(Index::parse(&raw).ok()?.chunks.iter().map(|record| record.id).collect())
}

fn lost(kept: &[ChunkRecord], scan: &Scan, expected: Option<&[ChunkId]>) -> Vec<ChunkId> {
    let torn = scan.damaged.iter().flat_map(|range| &range.chunks);
    let mut lost: BTreeSet<ChunkId> = torn.chain(expected.unwrap_or_default()).copied().collect();
    for record in kept {
        lost.remove(&record.id);
    }
    lost.remove(&ChunkId::INDX);
    lost.into_iter().collect()
}

/// Makes the temporary file, or opens the one that a killed repair left: that begins as a trace does. Anything else is somebody's own
/// file, and a link leads to one.
fn open_temporary(temporary: &Path) -> Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    let opened = match options.clone().create_new(true).open(temporary) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let hint = "it is no file that a repair left; name another output, or move it away";
            let foreign = || Error::occupied(temporary, Occupant::File { hint });
            match fs::symlink_metadata(temporary) {
                Ok(found) if found.is_file() => {}
                Err(error) if error.kind() == io::ErrorKind::NotFound => return open_temporary(temporary),
                _ => return Err(foreign()),
            }
            let file = ChunkFile::open(temporary, Limits::default())?;
            if !header_is_torn(&file)? {
                read_file_header(&file).map_err(|_| foreign())?;
            }
            options.open(temporary)
        }
        opened => opened,
    };
    opened.map_err(|error| Error::io(temporary, "create", error))
}

impl Writer {
    /// Copies a chunk as it is, reserved fields and all, checking it once more on the way.
    fn copy(&mut self, from: &ChunkFile, record: &ChunkRecord) -> Result<()> {
        let directory = match record.id.kind {
            ChunkKind::TILE => Some(from.tile_directory(record)?),
            _ => None,
        };
        let changed = || Error::corrupt(from.place(record.offset).of(record.id), "the file changed while it was read");
        let at = self.offset;
        let header = from.bytes(record.offset, CHUNK_HEADER_LEN)?;
        if ChunkHeader::parse(&header) != Ok(record.header()) {
            return Err(changed());
        }
        self.append(&[&header])?;
        let mut hasher = crc32fast::Hasher::new();
        let mut next = record.offset + CHUNK_HEADER_LEN;
        while next < record.end() {
            let bytes = from.bytes(next, (record.end() - next).min(STEP as u64))?;
            hasher.update(&bytes);
            self.append(&[&bytes])?;
            next += bytes.len() as u64;
        }
        if hasher.finalize() != record.payload_crc {
            return Err(changed());
        }
        self.push(ChunkRecord { offset: at, ..*record }, directory.as_ref());
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::container::writer::is_still;

    /// Another repair finishes and gives its file its name, after this one has opened it and before it has the lock.
    #[test]
    fn a_repair_that_another_has_finished_is_not_truncated() {
        let folder = tempfile::tempdir().unwrap();
        let (temporary, output) = (folder.path().join("out.repairing"), folder.path().join("out"));
        fs::write(&temporary, crate::container::file_header::FileHeader::encode(FormatVersion::CURRENT)).unwrap();
        let mut opened = 0;
        let locked = open_locked(&temporary, || {
            let file = open_temporary(&temporary)?;
            opened += 1;
            if opened == 1 {
                fs::rename(&temporary, &output).unwrap();
            }
            Ok(file)
        });
        let locked = locked.unwrap();
        assert!(opened == 2 && is_still(&locked, &temporary));
        locked.set_len(0).unwrap();
        assert_eq!(fs::metadata(&output).unwrap().len(), 32);
    }
}
