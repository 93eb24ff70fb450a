//! Whatever is whole in a damaged file is found again; damage stays where it is.

mod container_support;

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use container_support::{Content, NOTE, partial, patch, read_all, sample, sample_bytes, write};
use rayreel_formats::container::{
    ChunkId, ChunkRecord, EncodedChunk, Encoding, FormatVersion, Reader, RepairReport, Source, repair, scan,
    scan_source,
};
use rayreel_formats::error::{Fault, Occupant, Unknown};
use rayreel_formats::{Error, Limits, Result};
use tempfile::TempDir;

/// A folder with a damaged file.
struct Bench {
    folder: TempDir,
    input: PathBuf,
    output: PathBuf,
}

impl Bench {
    fn new() -> Self {
        let folder = container_support::folder();
        let (input, output) = (folder.path().join("in"), folder.path().join("out"));
        Self { folder, input, output }
    }

    fn try_repair(&self, bytes: &[u8]) -> Result<(RepairReport, Content)> {
        fs::write(&self.input, bytes).unwrap();
        fs::remove_file(&self.output).ok();
        let report = repair(&self.input, &self.output, &Limits::default())?;
        let reader = Reader::open(&self.output, Limits::default()).unwrap();
        assert_eq!(reader.len(), report.file_len);
        assert_eq!(reader.chunks().len() as u64, report.kept);
        assert!(scan(&self.output, &Limits::default()).unwrap().is_whole());
        Ok((report, read_all(&reader).unwrap()))
    }

    fn repair(&self, bytes: &[u8]) -> (RepairReport, Content) {
        self.try_repair(bytes).unwrap()
    }
}

fn records() -> Vec<ChunkRecord> {
    Reader::from_bytes(sample_bytes(), Limits::default()).unwrap().chunks().to_vec()
}

/// Ids in canonical order: the notes belong to the whole file.
fn canonical(keep: impl Fn(&ChunkRecord) -> bool) -> Vec<ChunkId> {
    let (notes, others): (Vec<_>, Vec<_>) = records().into_iter().filter(keep).partition(|record| record.id == NOTE);
    let mut ids: Vec<_> = others.iter().map(|record| record.id).collect();
    let files = ids.iter().take_while(|id| [ChunkId::META, ChunkId::BVH].contains(id)).count();
    ids.splice(files..files, notes.iter().map(|record| record.id));
    ids
}

fn ids(content: &Content) -> Vec<ChunkId> {
    content.payloads.iter().map(|(id, _)| *id).collect()
}

#[test]
fn a_whole_file_is_only_put_in_order() {
    let (report, content) = Bench::new().repair(&sample_bytes());
    assert_eq!(ids(&content), canonical(|_| true));
    assert_eq!((report.damaged.len(), report.lost.len(), report.duplicates), (0, 0, 0));
    assert!(report.had_index);
    let again = container_support::read_bytes(&sample_bytes()).unwrap();
    assert_eq!(content.totals, again.totals);
    for payload in &again.payloads {
        assert!(content.payloads.contains(payload));
    }
}

#[test]
fn repair_is_stable() {
    let bench = Bench::new();
    bench.repair(&sample_bytes());
    let once = fs::read(&bench.output).unwrap();
    bench.repair(&once);
    assert!(fs::read(&bench.output).unwrap() == once);
}

#[test]
fn chunks_before_a_cut_are_kept() {
    let (bench, whole) = (Bench::new(), sample_bytes());
    for cut in 0..whole.len() {
        let keep = |record: &ChunkRecord| record.end() <= cut as u64;
        match bench.try_repair(&whole[..cut]) {
            Ok((report, content)) => {
                assert_eq!(ids(&content), canonical(keep), "cut at {cut}");
                let lost = report.damaged.iter().map(|range| range.end - range.start).sum::<u64>();
                assert!(lost < 500 && report.damaged.len() <= 1);
            }
            Err(error) => {
                assert!(!records().iter().any(keep), "cut at {cut}: {error}");
                assert!(
                    matches!(
                        error,
                        Error::Unsupported { what: Unknown::File, .. }
                            | Error::Damaged { fault: Fault::Content(_), .. }
                    ),
                    "{error}"
                );
            }
        }
    }
}

#[test]
fn only_the_damaged_chunk_is_lost() {
    let (bench, whole) = (Bench::new(), sample_bytes());
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        let (report, content) = bench.repair(&bytes);
        let hit = |record: &ChunkRecord| (record.offset..record.end()).contains(&(at as u64));
        assert_eq!(ids(&content), canonical(|record| !hit(record)), "damaged at {at}");
        let known = |record: &ChunkRecord| hit(record) && record.id != NOTE;
        let lost: Vec<_> = records().into_iter().filter(known).map(|record| record.id).collect();
        let named: Vec<_> = report.lost.iter().copied().filter(|id| *id != NOTE).collect();
        assert_eq!(named, lost, "damaged at {at}: the index names what was lost");
        if let Some(record) = records().iter().find(|record| hit(record)) {
            assert_eq!(report.damaged.len(), 1);
            assert_eq!((report.damaged[0].start, report.damaged[0].end), (record.offset, record.end()));
        }
    }
}

/// Bytes that went missing or came in shift all that follows.
#[test]
fn chunks_behind_a_gap_are_found() {
    let (bench, whole) = (Bench::new(), sample_bytes());
    let records = records();
    for record in &records {
        let (start, end) = (record.offset as usize, record.end() as usize);
        let without = [&whole[..start + 20], &whole[end - 1..]].concat();
        let between = [&whole[..start], &b"\xf5RRC noise \xf5RRC"[..], &whole[start..]].concat();
        let (_, content) = bench.repair(&without);
        assert_eq!(ids(&content), canonical(|other| other != record));
        let (report, content) = bench.repair(&between);
        assert_eq!(ids(&content), canonical(|_| true));
        assert_eq!(report.damaged.len(), 1);
        assert_eq!(report.damaged[0].end - report.damaged[0].start, 15);
    }
}

#[test]
fn the_first_of_two_is_kept() {
    let whole = sample_bytes();
    let other = EncodedChunk::new(ChunkId::META, Encoding::Stored, b"other").unwrap();
    let (_folder, path) = write(&[other]);
    let twice = [&whole[..], &fs::read(path).unwrap()].concat();
    let (report, content) = Bench::new().repair(&twice);
    assert_eq!(report.duplicates, 1);
    assert_eq!(content.payloads[0].1, b"meta meta meta meta meta meta");
}

/// Any order of tiles is repaired into the canonical one: the bytes do not depend on the order of capture.
#[test]
fn order_does_not_matter() {
    let bench = Bench::new();
    let mut chunks = sample();
    chunks.retain(|chunk| chunk.id() != NOTE);
    let (_folder, path) = write(&chunks);
    bench.repair(&fs::read(path).unwrap());
    let forward = fs::read(&bench.output).unwrap();
    chunks.reverse();
    let (_folder, path) = write(&chunks);
    bench.repair(&fs::read(path).unwrap());
    assert!(fs::read(&bench.output).unwrap() == forward);
}

#[test]
fn versions_are_kept_and_newer_majors_refused() {
    let bench = Bench::new();
    let mut bytes = sample_bytes();
    patch(&mut bytes, 10, &3_u16.to_le_bytes(), 0, 28);
    assert_eq!(bench.repair(&bytes).0.version, FormatVersion { major: 1, minor: 3 });
    assert_eq!(Reader::open(&bench.output, Limits::default()).unwrap().version().minor, 3);
    bytes[3] = 0;
    assert_eq!(bench.repair(&bytes).0.version, FormatVersion::CURRENT);
    bytes = sample_bytes();
    patch(&mut bytes, 8, &2_u16.to_le_bytes(), 0, 28);
    assert!(matches!(bench.try_repair(&bytes), Err(Error::Unsupported { what: Unknown::Version { .. }, .. })));
}

#[test]
fn files_are_not_lost_by_a_repair() {
    let bench = Bench::new();
    let whole = sample_bytes();
    fs::write(&bench.input, &whole).unwrap();
    let limits = Limits::default();
    let same = bench.folder.path().join(".").join("in");
    assert!(matches!(repair(&bench.input, &same, &limits), Err(Error::Usage { .. })));
    fs::write(&bench.output, b"precious").unwrap();
    assert!(matches!(
        repair(&bench.input, &bench.output, &limits),
        Err(Error::Occupied { by: Occupant::File { .. }, .. })
    ));
    assert_eq!(fs::read(&bench.output).unwrap(), b"precious");
    // The natural use: NAME.partial becomes NAME.
    let name = bench.folder.path().join("name");
    fs::write(partial(&name), &whole[..whole.len() - 40]).unwrap();
    repair(&partial(&name), &name, &limits).unwrap();
    assert_eq!(fs::read(partial(&name)).unwrap().len(), whole.len() - 40);
    assert_eq!(fs::read_dir(bench.folder.path()).unwrap().count(), 4, "no temporary file is left");
}

/// What a killed repair left may be repaired itself, but not into the output that it was for.
#[test]
fn the_input_may_not_be_where_a_repair_writes() {
    let bench = Bench::new();
    let left = bench.folder.path().join("out.repairing");
    fs::write(&left, sample_bytes()).unwrap();
    assert!(matches!(repair(&left, &bench.output, &Limits::default()), Err(Error::Usage { .. })));
    assert_eq!(fs::read(&left).unwrap(), sample_bytes());
    repair(&left, &bench.folder.path().join("saved"), &Limits::default()).unwrap();
}

/// What a killed repair left is written over. A file or a link that only has its name is somebody's own.
#[test]
fn only_a_file_that_a_repair_left_is_written_over() {
    let bench = Bench::new();
    let whole = sample_bytes();
    fs::write(&bench.input, &whole).unwrap();
    let temporary = bench.folder.path().join("out.repairing");
    let run = || repair(&bench.input, &bench.output, &Limits::default());
    for left in [&whole[..0], &whole[..20], &whole[..100]] {
        fs::write(&temporary, left).unwrap();
        run().unwrap();
        fs::remove_file(&bench.output).unwrap();
        assert!(!temporary.exists());
    }
    let refused = || assert!(matches!(run(), Err(Error::Occupied { by: Occupant::File { .. }, .. })));
    fs::write(&temporary, "my notes on what I am repairing").unwrap();
    refused();
    assert_eq!(fs::read(&temporary).unwrap(), b"my notes on what I am repairing");
    fs::remove_file(&temporary).unwrap();
    #[cfg(unix)]
    {
        let mine = bench.folder.path().join("mine");
        fs::write(&mine, &whole).unwrap();
        std::os::unix::fs::symlink(&mine, &temporary).unwrap();
        refused();
        assert!(fs::symlink_metadata(&temporary).unwrap().is_symlink() && fs::read(&mine).unwrap() == whole);
        fs::remove_file(&temporary).unwrap();
    }
    fs::create_dir(&temporary).unwrap();
    refused();
}

#[derive(Debug)]
struct Counting {
    bytes: Vec<u8>,
    read: Arc<AtomicU64>,
}

impl Source for Counting {
    fn size(&self) -> std::io::Result<u64> {
        Ok(self.bytes.len() as u64)
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> std::io::Result<usize> {
        let rest = &self.bytes[(offset as usize).min(self.bytes.len())..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

/// A file of nothing but headers, each of which claims the rest of the file, would take the square of its length.
#[test]
fn nested_damage_is_walked_in_linear_time() {
    let header = &sample_bytes()[32..80];
    for count in [100_usize, 10_000, 40_000] {
        let mut bytes = Vec::new();
        for at in 0..count {
            let start = bytes.len();
            bytes.extend_from_slice(header);
            let rest = ((count - at - 1) * 48) as u64;
            patch(&mut bytes[start..], 32, &rest.to_le_bytes(), 0, 44);
        }
        let (len, read) = (bytes.len() as u64, Arc::new(AtomicU64::new(0)));
        let source = Counting { bytes, read: Arc::clone(&read) };
        let error = scan_source(Box::new(source), "nested".as_ref(), &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Unsupported { what: Unknown::File, .. }));
        assert!(read.load(Ordering::Relaxed) < 40 * len);
    }
}
