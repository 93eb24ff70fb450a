//! `rayreel completions` and `rayreel man`: what shells and `man` know of the program, made from its arguments.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap_complete::{Shell, generate};

use crate::common::print;
use crate::exit::Exit;

/// Print a script that completes commands and flags in a shell.
///
/// For bash: `rayreel completions bash > ~/.local/share/bash-completion/completions/rayreel`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell.
    shell: Shell,
}

/// Write a manual page for each command into a folder.
///
/// `man -l FOLDER/rayreel-replay.1` shows one; in a folder `man1` of the manual path, `man rayreel-replay` finds it.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// The folder; it is made if it is not there.
    folder: PathBuf,
}

pub fn run(args: &Args, mut program: clap::Command) -> Result<Exit> {
    let mut script = Vec::new();
    generate(args.shell, &mut program, "rayreel", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(Exit::Done)
}

pub fn run_man(args: &ManArgs, program: clap::Command) -> Result<Exit> {
    if args.folder.exists() && !args.folder.is_dir() {
        bail!("{} is no folder; name one that the man pages are written into", args.folder.display());
    }
    fs::create_dir_all(&args.folder).with_context(|| args.folder.display().to_string())?;
    clap_mangen::generate_to(program, &args.folder).with_context(|| args.folder.display().to_string())?;
    Ok(Exit::Done)
}
