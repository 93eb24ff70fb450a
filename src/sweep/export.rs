//! `rayreel sweep export`: templates for engines that are not tested here.

use std::path::PathBuf;

use anyhow::{Context, Result};
use rayreel_study::cluster::export::{ENGINES, Fill};
use rayreel_study::cluster::slurm::sbatch;
use rayreel_study::files::write_whole;
use rayreel_study::sweep::folder::Folder;

use super::folder::absolute;
use crate::common::print;
use crate::exit::Exit;

/// Write templates for another engine: HTCondor, IBM LSF, Kubernetes, AWS Batch, HyperQueue or GNU parallel.
///
/// They are NOT TESTED: read and edit them. They call what `submit` calls, `sweep run SWEEP --shard i/n` and `sweep merge SWEEP`, which
/// any engine may do in any order and any number of times.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a sweep.
    sweep: PathBuf,
    /// The engine.
    #[arg(long, value_parser = engines(), value_name = "ENGINE")]
    engine: String,
    /// Folder of the files; ENGINE in the folder of the sweep if it is not given.
    #[arg(long, short = 'o', value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Split the plan into so many shards.
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    shards: u32,
}

fn engines() -> clap::builder::PossibleValuesParser {
    ENGINES.iter().map(|engine| engine.name).collect::<Vec<_>>().into()
}

pub fn run(args: &Args) -> Result<Exit> {
    let folder = Folder::open(&args.sweep)?;
    let engine = ENGINES.iter().find(|engine| engine.name == args.engine).context("no such engine")?;
    let program = std::env::current_exe().context("cannot tell where this program is")?;
    let sweep = absolute(folder.path())?;
    [&program, &sweep].into_iter().try_for_each(|path| sbatch::check(path))?;
    // More shards than points would be jobs that do nothing.
    let shards = (args.shards as usize).min(folder.plan().points.len()).max(1);
    let out = args.out.clone().unwrap_or_else(|| folder.path().join(engine.name));
    let mut text = format!("{} (NOT TESTED: templates to edit), {shards} shards:\n", engine.title);
    for (name, contents) in engine.files(Fill { program: &program, sweep: &sweep, plan: folder.id(), shards }) {
        let path = out.join(name);
        write_whole(&path, contents.as_bytes())?;
        if name.ends_with(".sh") {
            executable(&path)?;
        }
        text += &format!("{}\n", path.display());
    }
    text += &format!("begin with `{}` there\n", engine.begin);
    print(&text)?;
    Ok(Exit::Done)
}

#[cfg(unix)]
fn executable(path: &std::path::Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let say = || format!("cannot make {} executable", path.display());
    let mut mode = std::fs::metadata(path).with_context(say)?.permissions();
    mode.set_mode(mode.mode() | 0o111);
    std::fs::set_permissions(path, mode).with_context(say)
}

#[cfg(not(unix))]
fn executable(_: &std::path::Path) -> Result<()> {
    Ok(())
}
