//! Pictures of a replayed frame.

use std::cell::OnceCell;
use std::io;
use std::ops::Range;
use std::path::Path;

use crate::error::Result;
use crate::point::wanted::{Kind, PictureWanted};
use rayreel_replay::FrameReplay;
use rayreel_replay::image::files::{self, ExrNotes};
use rayreel_replay::image::{Srgb8, errors, srgb};
use rayreel_replay::maps;

/// A frame of which pictures are made.
pub struct FramePictures<'a> {
    frame: &'a FrameReplay,
    /// Samples per pixel and axis.
    samples: u32,
    /// Encoded once for all pictures that need it.
    result: OnceCell<Srgb8>,
}

impl<'a> FramePictures<'a> {
    /// The pictures of a frame of so many samples per pixel and axis. None is made yet.
    pub fn new(frame: &'a FrameReplay, samples: u32) -> Self {
        Self { frame, samples, result: OnceCell::new() }
    }

    fn result(&self) -> &Srgb8 {
        self.result.get_or_init(|| srgb::encode(&self.frame.image))
    }

    /// A picture of a kind; nothing if the replay does not hold what it shows.
    ///
    /// # Errors
    /// Never for a frame of a replay: its pictures have one size.
    pub fn picture(&self, kind: Kind) -> Result<Option<Srgb8>> {
        let FrameReplay { reference, flip, states, blocks, .. } = self.frame;
        Ok(match kind {
            Kind::Result => Some(self.result().clone()),
            Kind::Reference => reference.as_ref().map(srgb::encode),
            Kind::Error => {
                let amplified = |full| errors::amplified(self.result(), &srgb::encode(full));
                reference.as_ref().map(amplified).transpose()?
            }
            Kind::Flip => flip.as_ref().map(errors::flip_picture),
            Kind::Similarity => Some(maps::similarity_map_pixels(states, blocks, self.samples)),
            Kind::Rate => Some(maps::rate_map_pixels(states, blocks, self.samples)),
        })
    }

    /// A picture as the bytes of a PNG file; empty if there is none of the kind.
    ///
    /// # Errors
    /// When it cannot be encoded.
    pub fn png(&self, wanted: &PictureWanted) -> Result<Vec<u8>> {
        let Some(picture) = self.picture(wanted.kind)? else { return Ok(Vec::new()) };
        Ok(files::png(&shrunk(picture, wanted.shrink))?)
    }

    /// Writes all pictures of the frame as files into `folder`; it is one of several of its trace or not, which is in their names
    /// ([`prefix`]), and `notes` stand in the EXR file.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path, several: bool, notes: &ExrNotes) -> Result<()> {
        let prefix = prefix(self.frame.frame.into(), several);
        let file = |name: &str| folder.join(format!("{prefix}{name}"));
        files::write_exr_with(&file(EXR), &self.frame.image, notes)?;
        for kind in Kind::ALL {
            if let Some(picture) = self.picture(kind)? {
                files::write_png(&file(&format!("{}.png", kind.name())), &picture)?;
            }
        }
        Ok(())
    }
}

/// The linear picture.
const EXR: &str = "result.exr";

/// What the names of a frame's pictures begin with: nothing where its trace has no other frame.
pub fn prefix(frame: u64, several: bool) -> String {
    if several { format!("frame_{frame:04}_") } else { String::new() }
}

/// Whether a file of this name is a picture of a replay: [`FramePictures::write`] gives such names.
pub fn is_picture(name: &str) -> bool {
    let numbered = name.strip_prefix("frame_").and_then(|rest| rest.split_once('_'));
    let number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let alone = numbered.filter(|(frame, _)| number(frame)).map_or(name, |(_, rest)| rest);
    let kind = |stem: &str| Kind::ALL.iter().any(|kind| kind.name() == stem);
    alone == EXR || alone.strip_suffix(".png").is_some_and(kind)
}

/// Removes from `folder` the pictures that an earlier replay of a trace of several frames left of these frames. One of a trace of a
/// single frame does not write over them, and they would be taken for its own.
///
/// # Errors
/// When one is there and cannot be removed.
pub fn remove_numbered(folder: &Path, frames: Range<u32>) -> io::Result<()> {
    let kinds = Kind::ALL.iter().map(|kind| format!("{}.png", kind.name()));
    let names: Vec<String> = kinds.chain([EXR.to_owned()]).collect();
    for frame in frames {
        let prefix = prefix(frame.into(), true);
        names.iter().try_for_each(|name| remove(&folder.join(format!("{prefix}{name}"))))?;
    }
    Ok(())
}

/// Removes a file; that there is none is as good.
///
/// # Errors
/// When it is there and cannot be removed.
pub fn remove(file: &Path) -> io::Result<()> {
    std::fs::remove_file(file).or_else(|e| if e.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(e) })
}

/// The mean of each `by` x `by` pixels; columns and rows that do not fill one are cut off.
fn shrunk(picture: Srgb8, by: u32) -> Srgb8 {
    let (width, height) = (picture.width / by, picture.height / by);
    if by == 1 || width == 0 || height == 0 {
        return picture;
    }
    let (pixels, row) = (width as usize * height as usize, width as usize);
    let mean = |i: usize| {
        let (left, top) = ((i % row) as u32 * by, (i / row) as u32 * by);
        let mut sums = [0u32; 3];
        for (x, y) in (top..top + by).flat_map(|y| (left..left + by).map(move |x| (x, y))) {
            let pixel = picture.pixels[y as usize * picture.width as usize + x as usize];
            sums.iter_mut().zip(pixel).for_each(|(sum, v)| *sum += u32::from(v));
        }
        sums.map(|sum| (sum / (by * by)) as u8)
    };
    Srgb8 { width, height, pixels: (0..pixels).map(mean).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_other_frames_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["frame_0002_result.png", "frame_0002_result.exr", "frame_0003_result.png", "frame_0002_notes.txt"];
        names.iter().for_each(|name| std::fs::write(folder.path().join(name), name).unwrap());
        remove_numbered(folder.path(), 1..3).unwrap();
        let left = names.map(|name| folder.path().join(name).exists());
        assert_eq!(left, [false, false, true, true]);
    }

    #[test]
    fn shrinking_takes_means() {
        let pixels = vec![[0; 3], [4, 8, 12], [9; 3], [4, 0, 4], [8, 8, 8], [9; 3]];
        let small = shrunk(Srgb8 { width: 3, height: 2, pixels }, 2);
        assert_eq!(small, Srgb8 { width: 1, height: 1, pixels: vec![[4, 4, 6]] });
    }
}
