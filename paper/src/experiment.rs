//! The experiment: planned, computed as far as it is not there, and put together as a study.

use rayreel_replay::Stop;
use rayreel_study::files::write_whole;
use rayreel_study::pool::Pool;
use rayreel_study::schema::{self, Study};

use crate::error::{PaperError, Result};
use crate::execute::execute;
use crate::ledger::{Ledger, PointCounts};
use crate::meter::Tell;
use crate::plan::Plan;
use crate::setup::{Folders, Setup};
use crate::study::Experiment;
use crate::{ablations, animation, points, rows, study, systems};

/// What came of an experiment.
pub struct Finished {
    /// All its results.
    pub study: Study,
    /// Where they came from.
    pub counts: PointCounts,
}

/// Name of the file with the points as rows.
const ROWS: &str = "paper.json";

/// Runs the experiment on so many threads: captures and computes what the cache folder does not hold, and writes the study and its
/// pictures into the output folder, which are there before this returns. `tell` is told how far it is.
///
/// # Errors
/// The first thing that fails; [`PaperError::is_interruption`] once `stop` is requested: what is finished is kept, and the next run
/// goes on there.
pub fn run(setup: &Setup, folders: &Folders, threads: usize, stop: &Stop, tell: &mut Tell<'_>) -> Result<Finished> {
    setup.check()?;
    folders.check()?;
    let mut plan = Plan::new(setup, folders.cache.clone());
    let experiment = Experiment {
        points: points::plan(setup, &mut plan),
        animation: animation::plan(setup, &mut plan),
        ablations: ablations::plan(setup, &mut plan)?,
        systems: systems::plan(setup, &mut plan)?,
    };
    let found = |finished: usize, ledger: &Ledger<'_>| {
        points::found(setup, &experiment.points, finished, |point| ledger.row(point))
    };
    let pool = Pool { threads, stop: stop.clone() };
    let (results, counts) = execute(&plan, folders, &pool, tell, &found)?;
    let study = study::study(setup, &experiment, &results)?;
    let json = serde_json::to_string_pretty(&study)
        .map_err(|_| PaperError::Fault { detail: "the study cannot be written as JSON" })?;
    write_whole(&folders.out.join(schema::FILE), (json + "\n").as_bytes())?;
    write_whole(&folders.out.join(ROWS), format!("{:#}\n", rows::rows(&study)).as_bytes())?;
    Ok(Finished { study, counts })
}
