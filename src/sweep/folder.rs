//! Plan files and the folders that are made of them.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rayreel_formats::trace::Trace;
use rayreel_settings::files;
use rayreel_store::{Location, in_folder};
use rayreel_study::analysis::load::is_sweep;
use rayreel_study::sweep::folder::{Created, Folder};
use rayreel_study::sweep::plan::Plan;
use rayreel_study::sweep::plan::locate::Text;

use crate::detail::DetailArgs;
use crate::exit::{self, Exit};
use crate::traces::CacheArgs;

/// Where the folder of a sweep is, and what a plan file does not say.
#[derive(Debug, Clone, clap::Args)]
pub struct FolderArgs {
    /// Folder of the sweep; NAME.sweep in the current folder for a plan file NAME.toml.
    #[arg(long = "out", short = 'o', value_name = "SWEEP")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub detail: DetailArgs,
}

impl FolderArgs {
    /// The folder for a plan file.
    pub fn folder(&self, file: &Path) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.sweep", stem(file))))
    }
}

fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(|| "plan".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Opens traces where a plan says that they are, or by their names in `traces`.
pub fn opener<'a>(cache: &'a CacheArgs, traces: Option<&'a str>) -> impl Fn(&str) -> Result<Trace, String> + Sync + 'a {
    move |location| {
        let location = Location::from(located(location, traces).as_str());
        cache.open(&location).map_err(|e| format!("{e:#}"))
    }
}

/// Where a trace of a plan is: there, or by its name in `traces`.
fn located(location: &str, traces: Option<&str>) -> String {
    let name = location.rsplit(['/', '\\']).next().unwrap_or(location);
    traces.map_or_else(|| location.to_owned(), |base| in_folder(base, name))
}

/// All points of a plan file; relative traces are in `traces`, or beside it.
pub fn read(file: &Path, place: &FolderArgs, traces: Option<&str>, cache: &CacheArgs) -> Result<Plan> {
    if file.is_dir() {
        bail!("{}", no_plan_file(file));
    }
    let text =
        files::read_text(file, files::TEXT_MAX).with_context(|| format!("cannot read the plan {}", file.display()))?;
    let name = file.display().to_string();
    let folder = file.parent().unwrap_or(Path::new(""));
    // A plan's error tells only in words why a trace cannot be opened. That a server or a disk fails is no fault of the plan.
    let failed = Cell::new(None);
    let open = |location: &str| {
        cache.open(&Location::from(location)).map_err(|error| {
            failed.set(failed.get().or(Some(exit::of(&error))));
            format!("{error:#}")
        })
    };
    let sources = rayreel_study::sweep::plan::Sources {
        text: Text { name: &name, text: &text },
        folder,
        traces,
        detail: place.detail.asked(),
        stem: &stem(file),
        open: &open,
    };
    let plan = Plan::new(&sources).map_err(|error| match failed.get() {
        Some(code @ (Exit::Unavailable | Exit::Io)) => exit::blaming(code, error),
        _ => error.into(),
    })?;
    for idle in &plan.idle {
        tell!("warning: {idle}");
    }
    Ok(plan)
}

/// What to do with a folder that stands where a plan file is asked for.
fn no_plan_file(folder: &Path) -> String {
    let name = folder.display();
    if is_sweep(folder) {
        return format!(
            "{name} is the folder of a sweep and not a plan file: `rayreel sweep run {name}` computes what is missing (on a cluster \
             `resume`), `status {name}` says how far it is, `merge {name}` makes its table"
        );
    }
    format!("{name} is a folder; name a plan file (.toml)")
}

/// Puts the plan of a file into its folder, or finds it there.
pub fn make(file: &Path, place: &FolderArgs, traces: Option<&str>, cache: &CacheArgs) -> Result<Folder> {
    let (folder, created) = Folder::create(&place.folder(file), read(file, place, traces, cache)?)?;
    if created == Created::Known {
        tell!("{}: going on with plan {}", folder.path().display(), folder.id());
    }
    Ok(folder)
}

/// The folder of a sweep, or that of a plan file.
pub fn find(sweep: &Path, place: &FolderArgs, traces: Option<&str>, cache: &CacheArgs) -> Result<Folder> {
    if sweep.is_file() {
        return make(sweep, place, traces, cache);
    }
    let folder = Folder::open(sweep)?;
    if let Some(out) = &place.out {
        bail!("-o {}: {} is the folder of a sweep already; -o is for a plan file", out.display(), sweep.display());
    }
    if let Some(asked) = place.detail.asked() {
        let planned = &folder.plan().details;
        if *planned != [asked.to_string()] {
            let (sweep, planned) = (sweep.display(), planned.join(", "));
            bail!(
                "--detail {asked}: the plan in {sweep} was made for {planned}; make another from the plan file, in another folder"
            );
        }
    }
    Ok(folder)
}

/// The folder as tasks on other machines find it.
pub fn absolute(path: &Path) -> Result<PathBuf> {
    use anyhow::Context;
    std::fs::canonicalize(path).with_context(|| format!("cannot find {}", path.display()))
}
