//! Blocks on disk, shared by all processes that read the same version of an object.
//!
//! ```text
//! <folder>/<hash of location, version and length>/object         what it is, for people; its date is that of the last use
//!                                                 <start>-<len>  a block: its bytes, then a hash; numbers are hexadecimal
//! ```
//!
//! A block is written under another name and renamed, so that it is complete or absent, whenever a process is killed. Its hash
//! covers its place too. Whatever is missing, damaged or deleted meanwhile is fetched again.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use rayreel_formats::durable::write_whole;

use super::memory::contains;
use crate::CacheFolder;

/// Digits of the name of an object's folder.
const KEY_LEN: usize = 32;
/// Bytes of the hash behind a block.
const HASH_LEN: usize = 32;
/// How long a list of files is believed: other processes add to them.
const LIST_FOR: Duration = Duration::from_secs(1);
/// A file that was not finished for this long never will be: its process was killed.
const ABANDONED: Duration = Duration::from_secs(3600);
/// The file that says what the object is.
const LABEL: &str = "object";

/// The blocks of one version of an object.
#[derive(Debug)]
pub(super) struct Disk {
    cache: CacheFolder,
    folder: PathBuf,
    key: blake3::Hash,
    known: Mutex<Known>,
    /// Bytes that may still be added; none once nothing else can be dropped.
    room: Mutex<Option<u64>>,
}

/// Blocks that are there, as far as is known: their ends by their starts. None lies within another.
#[derive(Debug)]
struct Known {
    blocks: BTreeMap<u64, u64>,
    listed: Instant,
}

impl Disk {
    /// Opens or makes the folder of an object; drops others if the whole holds more than it may.
    pub(super) fn open(cache: &CacheFolder, location: &str, version: &str) -> io::Result<Self> {
        let label = format!("{location}\n{version}\n");
        let key = blake3::hash(label.as_bytes());
        let folder = cache.path.join(&key.to_hex().as_str()[..KEY_LEN]);
        let make = || -> io::Result<()> {
            fs::create_dir_all(&folder)?;
            write_whole(&folder.join(LABEL), &[label.as_bytes()])
        };
        make().map_err(|error| {
            let hint = "name another folder with --trace-cache or RAYREEL_TRACE_CACHE, or give none to go without";
            io::Error::new(
                error.kind(),
                format!("cannot write into the cache {}: {error}; {hint}", cache.path.display()),
            )
        })?;
        let used = trim(cache, &folder, cache.max_bytes);
        let known = Known { blocks: list(&folder), listed: Instant::now() };
        let room = Mutex::new(Some(cache.max_bytes.saturating_sub(used)));
        Ok(Self { cache: cache.clone(), folder, key, known: Mutex::new(known), room })
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A block known to hold `wanted`, without looking at the disk.
    pub(super) fn holds(&self, wanted: &Range<u64>) -> bool {
        known(&self.lock().blocks, wanted).is_some()
    }

    /// A block that holds `wanted`. What other processes added is noticed, at the latest a moment later.
    pub(super) fn find(&self, wanted: &Range<u64>) -> Option<Range<u64>> {
        let mut state = self.lock();
        if let Some(range) = known(&state.blocks, wanted) {
            return Some(range);
        }
        if state.listed.elapsed() < LIST_FOR {
            return None;
        }
        state.blocks = list(&self.folder);
        state.listed = Instant::now();
        known(&state.blocks, wanted)
    }

    /// The bytes of a block, if it is there and whole.
    pub(super) fn load(&self, range: &Range<u64>) -> Option<Vec<u8>> {
        if self.lock().blocks.get(&range.start) != Some(&range.end) {
            return None;
        }
        let path = self.folder.join(name(range));
        let whole = fs::read(&path).ok().and_then(|mut bytes| {
            let len = bytes.len().checked_sub(HASH_LEN)?;
            let hash = bytes.split_off(len);
            (len as u64 == range.end - range.start && hash == self.hash(range, &bytes).as_bytes()).then_some(bytes)
        });
        if whole.is_none() {
            self.lock().blocks.remove(&range.start);
            fs::remove_file(&path).ok();
        }
        whole
    }

    /// Whether `len` bytes may be added. Drops other objects if there is no room for them, some more than needed, so that this
    /// is seldom done.
    fn take_room(&self, len: u64) -> bool {
        let mut room = self.room.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(mut left) = *room else { return false };
        if left < len {
            let used = trim(&self.cache, &self.folder, self.cache.max_bytes / 4 * 3);
            left = self.cache.max_bytes.saturating_sub(used);
        }
        *room = left.checked_sub(len);
        room.is_some()
    }

    /// Keeps a block, if there is room. A disk that is full or a folder that is gone is no error: the bytes are here.
    pub(super) fn store(&self, range: &Range<u64>, bytes: &[u8]) {
        if !self.take_room(bytes.len() as u64) {
            return;
        }
        let hash = self.hash(range, bytes);
        if write_whole(&self.folder.join(name(range)), &[bytes, hash.as_bytes()]).is_ok() {
            let needless = add(&mut self.lock().blocks, range);
            needless.iter().for_each(|old| _ = fs::remove_file(self.folder.join(name(old))));
        }
    }

    fn hash(&self, range: &Range<u64>, bytes: &[u8]) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new_keyed(self.key.as_bytes());
        hasher.update(&range.start.to_le_bytes()).update(bytes).finalize()
    }
}

fn name(range: &Range<u64>) -> String {
    format!("{:x}-{:x}", range.start, range.end - range.start)
}

/// The range of a block, by its name.
fn range_of(name: &str) -> Option<Range<u64>> {
    let (start, len) = name.split_once('-')?;
    let (start, len) = (u64::from_str_radix(start, 16).ok()?, u64::from_str_radix(len, 16).ok()?);
    (len > 0).then_some(start..start.checked_add(len)?)
}

/// The block that holds `wanted`. Since none lies within another, that is the one of the nearest start, or none.
fn known(blocks: &BTreeMap<u64, u64>, wanted: &Range<u64>) -> Option<Range<u64>> {
    let (&start, &end) = blocks.range(..=wanted.start).next_back()?;
    contains(&(start..end), wanted).then_some(start..end)
}

/// Adds a block unless another holds all of it; gives those that it makes needless, which are gone from the map.
fn add(blocks: &mut BTreeMap<u64, u64>, range: &Range<u64>) -> Vec<Range<u64>> {
    if known(blocks, range).is_some() {
        return Vec::new();
    }
    let within = blocks.range(range.start..range.end).filter(|&(_, &end)| end <= range.end);
    let within: Vec<Range<u64>> = within.map(|(&start, &end)| start..end).collect();
    within.iter().for_each(|old| _ = blocks.remove(&old.start));
    blocks.insert(range.start, range.end);
    within
}

fn names(folder: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok())
}

fn list(folder: &Path) -> BTreeMap<u64, u64> {
    let mut blocks = BTreeMap::new();
    names(folder).filter_map(|name| range_of(&name)).for_each(|range| _ = add(&mut blocks, &range));
    blocks
}

/// Drops what killed processes left in this object's folder, and other objects, those not opened for longest first, until the
/// cache holds at most `target` bytes. Gives the bytes of the blocks that are left. Whoever reads a dropped object fetches again.
fn trim(cache: &CacheFolder, own: &Path, target: u64) -> u64 {
    for name in names(own).filter(|name| name.starts_with('.')) {
        let path = own.join(name);
        if age(&path).is_some_and(|age| age > ABANDONED) {
            fs::remove_file(path).ok();
        }
    }
    let mut objects: Vec<(SystemTime, PathBuf, u64)> = Vec::new();
    // Nothing else that lies in the cache folder is ours.
    for name in names(&cache.path).filter(|name| name.len() == KEY_LEN && name.chars().all(|c| c.is_ascii_hexdigit())) {
        let folder = cache.path.join(name);
        let used = fs::metadata(folder.join(LABEL)).or_else(|_| fs::metadata(&folder));
        let Ok(used) = used.and_then(|file| file.modified()) else { continue };
        let bytes = names(&folder).filter_map(|name| range_of(&name)).map(|range| range.end - range.start).sum();
        objects.push((used, folder, bytes));
    }
    objects.sort();
    let mut total: u64 = objects.iter().map(|(_, _, bytes)| bytes).sum();
    for (_, folder, bytes) in objects.iter().filter(|(_, folder, _)| folder != own) {
        if total <= target {
            break;
        }
        // A reader that adds a block meanwhile keeps the folder alive; it is dropped another time.
        fs::remove_dir_all(folder).ok();
        total -= bytes;
    }
    total
}

fn age(path: &Path) -> Option<Duration> {
    SystemTime::now().duration_since(File::open(path).ok()?.metadata().ok()?.modified().ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_block_lies_within_another() {
        let mut blocks = BTreeMap::new();
        let mut put = |range: Range<u64>| add(&mut blocks, &range);
        assert_eq!(put(10..20), []);
        assert_eq!(put(12..15), [], "held already");
        assert_eq!(put(25..30), []);
        assert_eq!(put(18..28), []);
        assert_eq!(put(5..22).first(), Some(&(10..20)));
        assert_eq!(blocks, BTreeMap::from([(5, 22), (18, 28), (25, 30)]));
        for (wanted, held) in [(6..22, Some(5..22)), (19..28, Some(18..28)), (6..23, None), (26..30, Some(25..30))] {
            assert_eq!(known(&blocks, &wanted), held, "{wanted:?}");
        }
    }

    #[test]
    fn names_are_read_back() {
        assert_eq!(range_of(&name(&(255..1000))), Some(255..1000));
        assert_eq!(
            ["object", ".12-3", ".64-4.77-1.partial", "5-0", "ffffffffffffffff-1", "x-1", ""].map(range_of),
            [const { None }; 7]
        );
    }

    /// What a killed process leaves is never taken for a block, and goes when it is old.
    #[test]
    fn blocks_are_complete_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let disk = Disk::open(&cache, "s3://a/b", "one 5000").unwrap();
        disk.store(&(100..104), b"abcd");
        // What a writer of this very block left.
        const LEFT: &str = ".64-4.77-1.partial";
        fs::write(disk.folder.join(LEFT), b"ab").unwrap();
        let again = Disk::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert_eq!(again.find(&(101..103)), Some(100..104));
        assert_eq!(again.load(&(100..104)), Some(b"abcd".to_vec()));
        assert!(again.folder.join(LEFT).exists(), "its process may live");
        let file = File::options().write(true).open(again.folder.join(LEFT)).unwrap();
        file.set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
        Disk::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert!(!again.folder.join(LEFT).exists());
        for damaged in [&b"abcd"[..], b"", b"abcdefghijklmnopqrstuvwxyzabcdefghij"] {
            disk.store(&(100..104), b"abcd");
            fs::write(disk.folder.join("64-4"), damaged).unwrap();
            let again = Disk::open(&cache, "s3://a/b", "one 5000").unwrap();
            assert_eq!((again.load(&(100..104)), again.find(&(100..104))), (None, None));
        }
        assert_eq!(Disk::open(&cache, "s3://a/b", "two 5000").unwrap().find(&(100..104)), None, "another version");
    }
}
