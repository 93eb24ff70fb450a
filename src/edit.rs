//! What `trim`, `recompress` and `merge` share: a trace is written whole or not at all.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_formats::container::{ChunkId, ChunkKind};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Keep, Part, rewrite};

use crate::common::{keep_input, lacks, open, output_file, print};
use crate::exit::Exit;
use crate::progress::{self, Progress};

/// The trace to write.
#[derive(Clone, Debug, clap::Args)]
pub struct OutputArgs {
    /// Trace to write, by custom ending in .rtrace.
    #[arg(short, long, value_name = "FILE", value_parser = output_file())]
    output: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

impl OutputArgs {
    /// Writes the trace and says what it holds; `inputs` are the files that its parts are read from, which stay.
    pub fn write(&self, inputs: &[&Path], parts: &[Part<'_>], keep: &Keep, quiet: bool) -> Result<Exit> {
        let name = self.output.display();
        if self.output.is_dir() {
            bail!("{name} is a folder; name a file in it");
        }
        inputs.iter().try_for_each(|input| keep_input(&self.output, input))?;
        if self.output.exists() && !self.force {
            bail!("{name} already exists; give another name, or --force to replace it");
        }
        parts.iter().try_for_each(check_cameras)?;
        let frames: u64 = parts.iter().map(|part| part.frames.len() as u64).sum();
        let tiles = |part: &Part<'_>| u64::from(part.trace.meta().tile_count());
        let each = keep.tiles.as_ref().map_or_else(|| parts.first().map_or(0, tiles), |tiles| tiles.len() as u64);
        let stop = progress::stop_on_signal();
        let mut bar = Progress::new("write", frames * each, quiet);
        let written = rewrite(parts, keep, &self.output, |done| {
            bar.set(done, || format!("tile {done}"));
            !stop.is_requested()
        });
        match written {
            Ok(Some(_)) => bar.finish(),
            Ok(None) => {
                tell!("interrupted; nothing was written");
                return Ok(Exit::Interrupted);
            }
            Err(error) => return Err(error.into()),
        }
        for part in parts {
            let columns = part.trace.column_totals().iter();
            let unknown = columns.filter(|column| Column::ALL.iter().all(|known| *known as u8 != column.id)).count();
            if unknown > 0 {
                let name = part.trace.path().display();
                tell!("{name}: {unknown} columns that this version of rayreel does not know were left out");
            }
            let chunks = part.trace.reader().chunks().iter();
            let unknown = chunks.filter(|record| !record.id.kind.is_known()).count();
            if unknown > 0 {
                let name = part.trace.path().display();
                tell!("{name}: {unknown} chunks of kinds that this version of rayreel does not know were left out");
            }
        }
        let trace = open(&self.output)?;
        let (bytes, frames) = (trace.reader().len(), trace.meta().frame_numbers());
        print(&format!("{name}: frames {}..{}, {bytes} bytes\n", frames.start, frames.end))?;
        let lacks = lacks(&trace);
        if !lacks.is_empty() {
            print(&format!("it is not whole: {lacks}\n"))?;
        }
        Ok(Exit::Done)
    }
}

/// Refuses a frame whose tiles are there and whose camera is not: nothing can be made of it.
fn check_cameras(part: &Part<'_>) -> Result<()> {
    let trace = part.trace;
    let chunks = trace.reader().chunks().iter().map(|record| record.id);
    let mut tiles = chunks.filter(|id| id.kind == ChunkKind::TILE && part.frames.contains(&id.frame));
    match tiles.find(|id| !trace.has_frame(id.frame)) {
        Some(ChunkId { frame, .. }) => bail!(
            "{}: the camera of frame {frame} is lost, and its tiles say nothing without it; trim the other frames with --frames",
            trace.path().display()
        ),
        None => Ok(()),
    }
}
