//! Blocks on disk, shared by all processes that read the same version of an object.
//!
//! ```text
//! <folder>/<hash of location, version and length>/object         what it is, for people; its date: when it was last opened
//!                                                 <start>-<len>  a block: its bytes, then a hash; hexadecimal numbers
//! ```
//!
//! A block is written under another name and renamed, so that it is complete or absent, whenever a process is killed.
//! Its hash covers its place too. Whatever is missing, damaged or deleted meanwhile is fetched again.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayreel_formats::durable::{create_folders, write_whole};

use super::memory::{contains, overlaps};
use super::places::{KEY_LEN, LABEL, name, names, range_of};
use super::room::trim;
use crate::cache::CacheFolder;

/// Bytes of the hash behind a block.
const HASH_LEN: usize = 32;
/// How long a list of the folder is used before it is read again: other processes add files.
const LIST_FOR: Duration = Duration::from_secs(1);

/// The blocks of one version of an object.
#[derive(Debug)]
pub(super) struct DiskCache {
    cache: CacheFolder,
    folder: PathBuf,
    key: blake3::Hash,
    list: Mutex<BlockList>,
    room: Mutex<SpaceLeft>,
}

/// What may still be added to the cache.
#[derive(Debug)]
struct SpaceLeft {
    /// Bytes; `None` once nothing else can be dropped to make room.
    left: Option<u64>,
    /// Bytes that have their room and are being written: a look at the disk may miss them.
    writing: u64,
}

/// The blocks of the folder when it was last listed: their ends by their starts. None lies within another.
#[derive(Debug)]
struct BlockList {
    blocks: BTreeMap<u64, u64>,
    listed: Instant,
}

impl DiskCache {
    /// Opens or makes the folder of an object; drops others if the whole holds more than it may.
    pub(super) fn open(cache: &CacheFolder, location: &str, version: &str) -> io::Result<Self> {
        let label = format!("{location}\n{version}\n");
        let key = blake3::hash(label.as_bytes());
        let folder = cache.path.join(&key.to_hex().as_str()[..KEY_LEN]);
        let make = || -> io::Result<()> {
            create_folders(&folder)?;
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
        let blocks = BlockList { blocks: list(&folder), listed: Instant::now() };
        let room = Mutex::new(SpaceLeft { left: Some(cache.max_bytes.saturating_sub(used)), writing: 0 });
        Ok(Self { cache: cache.clone(), folder, key, list: Mutex::new(blocks), room })
    }

    fn lock(&self) -> MutexGuard<'_, BlockList> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A block known to hold `wanted`, without looking at the disk.
    pub(super) fn holds(&self, wanted: &Range<u64>) -> bool {
        holder(&self.lock().blocks, wanted).is_some()
    }

    /// A block that holds `wanted`. What other processes added is noticed, at the latest a moment later.
    pub(super) fn find(&self, wanted: &Range<u64>) -> Option<Range<u64>> {
        let mut state = self.lock();
        if let Some(range) = holder(&state.blocks, wanted) {
            return Some(range);
        }
        if state.listed.elapsed() < LIST_FOR {
            return None;
        }
        state.blocks = list(&self.folder);
        state.listed = Instant::now();
        holder(&state.blocks, wanted)
    }

    /// The bytes of a block, if it is there and whole.
    pub(super) fn load(&self, range: &Range<u64>) -> Option<Vec<u8>> {
        if self.lock().blocks.get(&range.start) != Some(&range.end) {
            return None;
        }
        let path = self.folder.join(name(range));
        let whole = fs::read(&path).map(|bytes| self.checked(range, bytes));
        if !matches!(whole, Ok(Some(_))) {
            self.lock().blocks.remove(&range.start);
        }
        // A block that cannot be read now, because too many files are open, may be sound: only what was read condemns it.
        if matches!(whole, Ok(None)) {
            fs::remove_file(&path).ok();
        }
        whole.ok().flatten()
    }

    /// The bytes of a block without the hash behind them, if length and hash are right.
    fn checked(&self, range: &Range<u64>, mut bytes: Vec<u8>) -> Option<Vec<u8>> {
        let len = bytes.len().checked_sub(HASH_LEN)?;
        let hash = bytes.split_off(len);
        (len as u64 == range.end - range.start && hash == self.hash(range, &bytes).as_bytes()).then_some(bytes)
    }

    /// Drops all blocks with some of these bytes; the folder of the cache.
    pub(super) fn forget(&self, range: &Range<u64>) -> &Path {
        let mut state = self.lock();
        // Those too that lie within another one, which a list leaves out.
        let blocks = names(&self.folder).filter_map(|name| range_of(&name));
        for block in blocks.filter(|block| overlaps(block, range)) {
            fs::remove_file(self.folder.join(name(&block))).ok();
        }
        state.blocks = list(&self.folder);
        &self.cache.path
    }

    fn room(&self) -> MutexGuard<'_, SpaceLeft> {
        self.room.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether `len` bytes may be added. Drops other objects if there is no room for them, some more than needed, so
    /// that this is seldom done.
    fn take_room(&self, len: u64) -> bool {
        let mut room = self.room();
        let Some(mut left) = room.left else { return false };
        if left < len {
            let used = trim(&self.cache, &self.folder, self.cache.max_bytes / 4 * 3) + room.writing;
            left = self.cache.max_bytes.saturating_sub(used);
        }
        room.left = left.checked_sub(len);
        room.writing += room.left.map_or(0, |_| len);
        room.left.is_some()
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
        self.room().writing -= bytes.len() as u64;
    }

    fn hash(&self, range: &Range<u64>, bytes: &[u8]) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new_keyed(self.key.as_bytes());
        hasher.update(&range.start.to_le_bytes()).update(bytes).finalize()
    }
}

/// The block that holds `wanted`. Since none lies within another, that is the one of the nearest start, or none.
fn holder(blocks: &BTreeMap<u64, u64>, wanted: &Range<u64>) -> Option<Range<u64>> {
    let (&start, &end) = blocks.range(..=wanted.start).next_back()?;
    contains(&(start..end), wanted).then_some(start..end)
}

/// Adds a block unless another holds all of it; gives those that it makes needless, which are gone from the map.
fn add(blocks: &mut BTreeMap<u64, u64>, range: &Range<u64>) -> Vec<Range<u64>> {
    if holder(blocks, range).is_some() {
        return Vec::new();
    }
    let within = blocks.range(range.start..range.end).filter(|&(_, &end)| end <= range.end);
    let within: Vec<Range<u64>> = within.map(|(&start, &end)| start..end).collect();
    within.iter().for_each(|old| _ = blocks.remove(&old.start));
    blocks.insert(range.start, range.end);
    within
}

fn list(folder: &Path) -> BTreeMap<u64, u64> {
    let mut blocks = BTreeMap::new();
    // What has the name of a block and is none, such as a folder, is passed by.
    let files = names(folder).filter(|name| range_of(name).is_some() && folder.join(name).is_file());
    files.filter_map(|name| range_of(&name)).for_each(|range| _ = add(&mut blocks, &range));
    blocks
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;
    use crate::remote::room::{ABANDONED, cached_objects, drop_objects, trim};

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
            assert_eq!(holder(&blocks, &wanted), held, "{wanted:?}");
        }
    }

    /// What a killed process leaves is never taken for a block, and goes when it is old.
    #[test]
    fn blocks_are_complete_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let disk = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        disk.store(&(100..104), b"abcd");
        // What a writer of this very block left.
        const LEFT: &str = ".64-4.77-1.partial";
        fs::write(disk.folder.join(LEFT), b"ab").unwrap();
        let again = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert_eq!(again.find(&(101..103)), Some(100..104));
        assert_eq!(again.load(&(100..104)), Some(b"abcd".to_vec()));
        assert!(again.folder.join(LEFT).exists(), "its process may live");
        let file = fs::File::options().write(true).open(again.folder.join(LEFT)).unwrap();
        file.set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
        DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert!(!again.folder.join(LEFT).exists());
        for damaged in [&b"abcd"[..], b"", b"abcdefghijklmnopqrstuvwxyzabcdefghij"] {
            disk.store(&(100..104), b"abcd");
            fs::write(disk.folder.join("64-4"), damaged).unwrap();
            let again = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
            assert_eq!((again.load(&(100..104)), again.find(&(100..104))), (None, None));
        }
        assert_eq!(DiskCache::open(&cache, "s3://a/b", "two 5000").unwrap().find(&(100..104)), None, "another version");
    }

    /// An error while a block is read says nothing about the block. A link to itself cannot be read, by root either.
    #[cfg(unix)]
    #[test]
    fn a_block_that_cannot_be_read_is_not_deleted() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let disk = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        disk.store(&(100..104), b"abcd");
        let (block, aside) = (disk.folder.join("64-4"), folder.path().join("aside"));
        fs::rename(&block, &aside).unwrap();
        std::os::unix::fs::symlink("64-4", &block).unwrap();
        assert_eq!((disk.load(&(100..104)), disk.find(&(100..104))), (None, None), "it is fetched");
        assert!(fs::symlink_metadata(&block).is_ok(), "and stays");
        fs::rename(&aside, &block).unwrap();
        let again = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert_eq!(again.load(&(100..104)), Some(b"abcd".to_vec()));
    }

    /// Two objects of 100 bytes and one of 50 that is being read; what a killed process left counts, what this one writes does not.
    #[test]
    fn only_what_is_gone_makes_room() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let open = |name: &str| DiskCache::open(&cache, name, "one 5000").unwrap();
        let (stuck, other, current) = (open("s3://a/stuck"), open("s3://a/other"), open("s3://a/current"));
        stuck.store(&(0..100), &[1; 100]);
        other.store(&(0..70), &[2; 70]);
        fs::write(other.folder.join(".0-46.1-1.partial"), [0; 30]).unwrap();
        current.store(&(0..50), &[3; 50]);
        fs::write(current.folder.join(format!(".64-4.{}-1.partial", std::process::id())), [0; 30]).unwrap();
        let remove = |path: &Path| {
            if path == stuck.folder { Err(io::ErrorKind::PermissionDenied.into()) } else { fs::remove_dir_all(path) }
        };
        let trimmed = |target| drop_objects(cached_objects(&cache.path), &current.folder, target, remove);
        assert_eq!(trimmed(250), 250, "it fits");
        assert_eq!(trimmed(0), 150, "one cannot be deleted, one is being read");
        assert!(stuck.folder.exists() && !other.folder.exists());
    }

    /// A folder of somebody else's with a name like that of an object went with all that was in it.
    #[test]
    fn what_is_not_ours_stays() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let open = |name: &str| DiskCache::open(&cache, name, "one 5000").unwrap();
        let (old, current) = (open("s3://a/old"), open("s3://a/current"));
        old.store(&(0..100), &[1; 100]);
        let foreign = folder.path().join("0123456789abcdef0123456789abcdef");
        fs::create_dir(&foreign).unwrap();
        for name in ["thesis.tex", "object"] {
            fs::write(foreign.join(name), "precious").unwrap();
        }
        trim(&cache, &current.folder, 0);
        assert_eq!(fs::read_dir(&foreign).unwrap().count(), 2);
        assert!(!old.folder.exists());
    }

    /// A look at the disk, for what may be dropped, misses blocks that another thread is writing.
    #[test]
    fn blocks_that_are_being_written_have_their_room() {
        let folder = tempfile::tempdir().unwrap();
        let cache = CacheFolder { path: folder.path().to_path_buf(), max_bytes: 1000 };
        let disk = DiskCache::open(&cache, "s3://a/b", "one 5000").unwrap();
        assert!(disk.take_room(400) && disk.take_room(500));
        assert!(!disk.take_room(300), "there is nothing to drop");
    }
}
