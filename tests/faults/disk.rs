//! What a disk holds apart from what a process sees: `data/INODE` has the bytes of a file as they were last synced, `dirs/INODE`
//! the names of a folder, a line each: inode, `d` or `f`, name.

use std::fmt::Write;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Makes a disk that holds a folder as it is.
pub fn write(disk: &Path, folder: &Path) {
    fs::remove_dir_all(disk).ok();
    ["data", "dirs"].iter().for_each(|part| fs::create_dir_all(disk.join(part)).unwrap());
    write_folder(disk, folder);
}

fn inode(path: &Path) -> u64 {
    fs::symlink_metadata(path).unwrap().ino()
}

fn write_folder(disk: &Path, folder: &Path) {
    let mut names = String::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name());
        let kind = if path.is_dir() { 'd' } else { 'f' };
        writeln!(names, "{} {kind} {}", inode(&path), name.to_str().unwrap()).unwrap();
        if path.is_dir() {
            write_folder(disk, &path);
        } else {
            fs::copy(&path, disk.join("data").join(inode(&path).to_string())).unwrap();
        }
    }
    fs::write(disk.join("dirs").join(inode(folder).to_string()), names).unwrap();
}

/// Leaves in the folder what is on the disk: the names that were synced, or all names (`names` false), and of each file the bytes that
/// were synced.
pub fn read(disk: &Path, folder: &Path, names: bool) {
    let (old, root) = (folder.with_extension("old"), inode(folder));
    fs::remove_dir_all(&old).ok();
    fs::rename(folder, &old).unwrap();
    fs::create_dir(folder).unwrap();
    if names { by_names(disk, root, folder) } else { by_sight(disk, &old, folder) }
}

/// Names as they were synced.
fn by_names(disk: &Path, inode: u64, to: &Path) {
    let Ok(names) = fs::read_to_string(disk.join("dirs").join(inode.to_string())) else { return };
    for line in names.lines() {
        let mut words = line.splitn(3, ' ');
        let mut word = || words.next().unwrap();
        let (inode, kind, to) = (word().parse().unwrap(), word(), to.join(word()));
        if kind == "d" {
            fs::create_dir(&to).unwrap();
            by_names(disk, inode, &to);
        } else {
            fs::write(to, bytes(disk, inode)).unwrap();
        }
    }
}

/// Names as the process saw them.
fn by_sight(disk: &Path, from: &Path, to: &Path) {
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            fs::create_dir(&to).unwrap();
            by_sight(disk, &from, &to);
        } else {
            fs::write(to, bytes(disk, inode(&from))).unwrap();
        }
    }
}

/// The bytes of a file that were synced; none if it never was.
fn bytes(disk: &Path, inode: u64) -> Vec<u8> {
    fs::read(disk.join("data").join(inode.to_string())).unwrap_or_default()
}
