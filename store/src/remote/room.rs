//! Makes room in a cache folder: counts what lies in it, and drops objects.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use rayreel_formats::durable::PARTIAL;

use super::places::{KEY_LEN, LABEL, names, range_of};
use crate::cache::CacheFolder;

/// Age at which an unfinished file is taken to be left by a killed process.
pub(super) const ABANDONED: Duration = Duration::from_secs(3600);

/// Makes room. Drops the unfinished files of killed processes in `current`, the folder of the object that is being
/// read; then other objects, those not opened for longest first, until the cache holds at most `target` bytes. Whoever
/// reads a dropped object fetches it again.
///
/// Gives the bytes of the blocks and unfinished files that are left.
pub(super) fn trim(cache: &CacheFolder, current: &Path, target: u64) -> u64 {
    drop_abandoned(current);
    drop_objects(cached_objects(&cache.path), current, target, drop_object)
}

/// Drops the folder of an object. One that holds anything but what the cache itself writes is none of ours, and stays as it is.
fn drop_object(folder: &Path) -> io::Result<()> {
    let is_ours =
        |name: &String| name == LABEL || range_of(name).is_some() || name.starts_with('.') && name.ends_with(PARTIAL);
    if !names(folder).all(|name| is_ours(&name)) {
        return Err(io::ErrorKind::DirectoryNotEmpty.into());
    }
    for name in names(folder) {
        match fs::remove_file(folder.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    fs::remove_dir(folder)
}

/// Drops objects by `remove`, and counts what is gone: a folder of another user's stays, and one in which a reader adds a block
/// meanwhile.
pub(super) fn drop_objects(
    mut objects: Vec<CachedObject>,
    current: &Path,
    target: u64,
    remove: impl Fn(&Path) -> io::Result<()>,
) -> u64 {
    objects.sort();
    // Of the current object the files that this process is writing have their room already.
    let of = |object: &CachedObject| object.bytes - if object.folder == current { object.writing } else { 0 };
    let mut total: u64 = objects.iter().map(of).sum();
    for object in objects.iter().filter(|object| object.folder != current) {
        if total <= target {
            break;
        }
        let left = if remove(&object.folder).is_ok() { 0 } else { held(&object.folder).0 };
        total = total.saturating_sub(object.bytes.saturating_sub(left));
    }
    total
}

fn drop_abandoned(folder: &Path) {
    for name in names(folder).filter(|name| name.starts_with('.')) {
        let path = folder.join(name);
        if age(&path).is_some_and(|age| age > ABANDONED) {
            fs::remove_file(path).ok();
        }
    }
}

/// An object in the cache. The one not opened for longest sorts first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CachedObject {
    opened: SystemTime,
    folder: PathBuf,
    /// Bytes of its blocks and unfinished files.
    bytes: u64,
    /// Those of the unfinished files of this process.
    writing: u64,
}

/// All objects of a cache folder. Whatever else lies in it is left alone.
pub(super) fn cached_objects(cache: &Path) -> Vec<CachedObject> {
    let is_key = |name: &String| name.len() == KEY_LEN && name.chars().all(|c| c.is_ascii_hexdigit());
    let object = |name: String| {
        let folder = cache.join(name);
        let opened =
            fs::metadata(folder.join(LABEL)).or_else(|_| fs::metadata(&folder)).and_then(|file| file.modified());
        let (bytes, writing) = held(&folder);
        Some(CachedObject { opened: opened.ok()?, folder, bytes, writing })
    };
    names(cache).filter(is_key).filter_map(object).collect()
}

/// Bytes of the blocks and unfinished files in the folder of an object, and those of unfinished files of this process alone.
fn held(folder: &Path) -> (u64, u64) {
    let of_this_process = format!(".{}-", std::process::id());
    let (mut bytes, mut writing) = (0, 0);
    for name in names(folder) {
        if let Some(range) = range_of(&name) {
            bytes += range.end - range.start;
        } else if name.starts_with('.') && name.ends_with(PARTIAL) {
            let len = fs::symlink_metadata(folder.join(&name)).map_or(0, |file| file.len());
            bytes += len;
            writing += if name.contains(&of_this_process) { len } else { 0 };
        }
    }
    (bytes, writing)
}

fn age(path: &Path) -> Option<Duration> {
    SystemTime::now().duration_since(File::open(path).ok()?.metadata().ok()?.modified().ok()?).ok()
}
